#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "commands.h"
#include "crg/file.h"
#include "explain/discs.h"
#include "explain/explain.h"
#include "explain/fuel.h"
#include "explain/kept.h"
#include "explain/page.h"
#include "explain/plausible_car.h"
#include "explain/short_waves.h"
#include "explain/simulate.h"
#include "explain/write_back.h"
#include "files/sha256.h"
#include "files/write_file.h"
#include "stages.h"
#include "vehicle/error.h"

namespace crgexplain {
namespace {

/// The corrected inputs, as they are called in the folder of the result.
std::vector<std::string> corrected_names() {
  std::vector<std::string> out{"track.crg", "friction.crg", "vehicle.yaml", "mapping.yaml"};
  out.insert(out.end(), explain::kCarFiles.begin(), explain::kCarFiles.end());
  return out;
}

/// vehicle.yaml comes last: whoever finds it finds what it names.
void write_car(const explain::CorrectedCar& car, const std::string& folder) {
  for (const auto& [name, text] : car.files) files::write_file(folder + "/" + name, text);
  files::write_file(folder + "/vehicle.yaml", car.vehicle_yaml);
}

/// Nothing that is read may lie where a corrected input will be written.
void refuse_to_overwrite(const std::vector<std::string>& inputs, const std::string& folder) {
  for (const std::string& input : inputs)
    for (const std::string& name : corrected_names()) {
      std::error_code none;
      const std::filesystem::path written = std::filesystem::path(folder) / name;
      if (!input.empty() && std::filesystem::equivalent(input, written, none))
        throw vehicle::Error(fmt::format("{}: is read, and -o {} would overwrite it; choose another folder", input, folder));
    }
}

/// Everything that the result depends on: this program, names and bytes of all inputs, options.
std::string hash_of(const RunCommand& command, const std::vector<std::string>& inputs) {
  std::string all = files::sha256_of_file("/proc/self/exe");
  for (const std::string& input : inputs)
    if (!input.empty()) all += fmt::format("\n{} {}", input, files::sha256_of_file(input));
  all += fmt::format("\n{} {} {}", command.nulls, fmt::join(command.hold_out, ","), command.fuel_kg);
  return files::sha256(all);
}

}  // namespace

explain::Findings look(const std::vector<explain::RecordedLog>& recorded, const std::vector<explain::Signals>& logs, const explain::Mapping& mapping, const crg::Surface& surface,
                       const vehicle::Vehicle& car, const explain::ExplainOptions& options) {
  explain::Findings findings = explain::explain(logs, car, options);
  explain::add_short_waves(findings, recorded, mapping, surface, car);
  explain::add_discs(findings, recorded, mapping, car);
  explain::doubt_the_car(findings);
  return findings;
}

int run(const RunCommand& command) {
  if (!std::isfinite(command.fuel_kg)) throw vehicle::Error("--fuel-kg is no number; kilograms are wanted");
  const vehicle::Vehicle car = vehicle::read_vehicle(command.vehicle_path);
  std::vector<std::string> inputs = car.read_files;
  inputs.insert(inputs.end(), {command.track_path, command.friction_path, command.mapping_path});
  inputs.insert(inputs.end(), command.recording_paths.begin(), command.recording_paths.end());
  refuse_to_overwrite(inputs, command.out_path);
  crg::SurfaceOptions known;
  if (!command.friction_path.empty()) known.friction_map = crg::read(command.friction_path);
  const crg::Surface surface(crg::read(command.track_path), known);
  std::vector<explain::Signals> logs;
  std::vector<vehicle::Table> tables;
  explain::Mapping mapping, used;
  std::vector<std::string> notes;
  if (!command.mapping_path.empty()) mapping = {vehicle::read_mapping(command.mapping_path), {}};
  for (const std::string& path : command.recording_paths) {
    tables.push_back(vehicle::read_table(path));
    used = command.mapping_path.empty() ? explain::identity_mapping(tables.back()) : mapping;
    for (const std::string& note : used.notes) notes.push_back(path + ": " + note);
    logs.push_back(explain::make_signals(tables.back(), used, surface, path));
  }
  if (command.fuel_kg > 0)
    for (std::size_t k = 0; k < logs.size(); ++k) {
      explain::Mapping own = command.mapping_path.empty() ? explain::identity_mapping(tables[k]) : mapping;
      explain::add_fuel(tables[k], own, logs[k], car, command.fuel_kg);
      logs[k] = explain::make_signals(tables[k], own, surface, command.recording_paths[k]);
      used = own;
    }
  explain::ExplainOptions options;
  options.hold_out.insert(command.hold_out.begin(), command.hold_out.end());
  options.threads = command.threads;
  options.nulls = command.nulls;
  const bool terminal = isatty(2) != 0;
  if (terminal)
    options.progress = [](const std::string& stage, double share) { std::fprintf(stderr, "\r\033[K%s %3.0f %%", stage.c_str(), 100 * share); };
  std::vector<explain::RecordedLog> recorded;
  for (std::size_t k = 0; k < logs.size(); ++k) recorded.push_back({&tables[k], &logs[k]});
  std::filesystem::create_directories(command.out_path);
  const Stages stages(command.out_path, hash_of(command, inputs));
  if (const auto taken = stages.taken_up(); !taken.empty())
    fmt::print(stderr, "goes on where a run was stopped; finished: {}\n", fmt::join(taken, ", "));
  auto findings = stages.get<explain::Findings>(
      "relations", [&] { return look(recorded, logs, used, surface, car, options); }, explain::findings_from_bytes, [](const auto& f) { return explain::to_bytes(f); });
  findings.remarks.insert(findings.remarks.begin(), notes.begin(), notes.end());
  // The corrected inputs, and nothing left over from an earlier run.
  std::string track = command.track_path, vehicle = command.vehicle_path, again, friction = command.friction_path;
  for (const std::string& name : corrected_names()) std::filesystem::remove(std::filesystem::path(command.out_path) / name);
  if (const auto road = explain::corrected_road(surface.file(), findings)) {
    track = command.out_path + "/track.crg";
    crg::write(*road, track, surface.file().format);
  }
  if (const auto grip = explain::friction_map(surface.file(), known.friction_map ? &*known.friction_map : nullptr, findings)) {
    friction = command.out_path + "/friction.crg";
    crg::write(*grip, friction, surface.file().format);
  }
  double fuel_kg = command.fuel_kg;
  if (const auto made = explain::corrected_vehicle(command.vehicle_path, car, findings, logs)) {
    vehicle = command.out_path + "/vehicle.yaml";
    write_car(*made, command.out_path);
    if (made->fuel_kg > 0) fuel_kg = made->fuel_kg;
  }
  // What is handed out is about the log as it was recorded, without the fuel that was given here.
  explain::Mapping recorded_columns = used;
  if (command.fuel_kg > 0) recorded_columns.columns.pop_back();
  const auto corrected = explain::corrected_mapping(recorded_columns, car, findings, logs);
  if (corrected) {
    again = " --mapping " + command.out_path + "/mapping.yaml";
    files::write_file(command.out_path + "/mapping.yaml", explain::format_mapping(*corrected));
  } else if (!command.mapping_path.empty()) {
    again = " --mapping " + command.mapping_path;
  }
  if (!findings.findings.empty() && !command.skip_simulation) {
    if (terminal) std::fprintf(stderr, "the whole simulated car, before and after");
    const vehicle::Vehicle improved = vehicle::read_vehicle(vehicle);
    crg::SurfaceOptions grip;
    if (!friction.empty()) grip.friction_map = crg::read(friction);
    const crg::Surface road(crg::read(track), grip);
    explain::Mapping driven = corrected ? *corrected : used;
    if (corrected && command.fuel_kg > 0) driven.columns.push_back(used.columns.back());
    if (fuel_kg > command.fuel_kg)
      for (std::size_t k = 0; k < logs.size(); ++k) {
        explain::Mapping own = corrected ? *corrected : used;
        explain::add_fuel(tables[k], own, logs[k], improved, fuel_kg);
        driven = own;
      }
    const explain::SimulationCheck check =
        explain::check_simulation(recorded, {&car, &surface, used}, {&improved, &road, driven}, options.hold_out,
                                  [&](bool after, const std::function<explain::RefittedCar()>& make) {
                                    return stages.get<explain::RefittedCar>(after ? "refit after" : "refit before", make, explain::car_from_bytes,
                                                                            [](const auto& c) { return explain::to_bytes(c); });
                                  });
    for (explain::Finding& f : findings.findings) f.held_out.insert(f.held_out.end(), check.held_out.begin(), check.held_out.end());
    findings.remarks.insert(findings.remarks.end(), check.remarks.begin(), check.remarks.end());
    findings.driven = check.driven;
    findings.recorded_lap_s = check.recorded_lap_s;
    if (std::isfinite(check.lap_before_s)) findings.simulated_lap_before_s = check.lap_before_s;
    if (std::isfinite(check.lap_after_s)) findings.simulated_lap_after_s = check.lap_after_s;
    // What was driven is what is handed out.
    if (vehicle != command.vehicle_path && check.after && !check.after->changed.empty())
      write_car(*explain::corrected_vehicle(command.vehicle_path, car, findings, logs, &*check.after), command.out_path);
    if (terminal) std::fprintf(stderr, "\r\033[K");
  }
  files::write_file(command.out_path + "/findings.json", explain::findings_json(findings));
  files::write_file(command.out_path + "/report.html", explain::findings_page(findings, logs, fmt::format("Simulation and recording: {} on {}", car.name, std::filesystem::path(command.track_path).stem().string())));
  stages.done();

  fmt::print("verdict: {}\n", findings.verdict);
  for (const explain::Finding& f : findings.findings) {
    fmt::print("  {}{}: {}\n", f.mechanism, f.channel.empty() ? "" : " (" + f.channel + ")", f.physics);
    for (const explain::FoundParameter& p : f.parameters)
      fmt::print("    {} = {:.4g} {} [{:.4g}, {:.4g}]\n", p.name, p.value, p.unit, p.low, p.high);
    for (const explain::Place& w : f.where) fmt::print("    u {:.0f} to {:.0f} m\n", w.u_begin_m, w.u_end_m);
    for (const explain::Rival& r : f.rivals)
      if (!r.separable) fmt::print("    cannot be told from {}: {}\n", r.mechanism, r.separating_experiment);
  }
  for (const explain::Unexplained& u : findings.unexplained)
    fmt::print("  unexplained: {} over {}{}, {:.3g} {}\n", u.channel, u.locked_to,
               u.where.empty() ? "" : fmt::format("{} from {:.0f} to {:.0f} m", u.locked_to == "u" ? "" : ", first at u", u.where[0].u_begin_m, u.where[0].u_end_m), u.size, u.unit);
  for (const std::string& remark : findings.remarks) fmt::print("  {}\n", remark);
  if (track != command.track_path) fmt::print("corrected road: {}\n", track);
  if (friction != command.friction_path) fmt::print("grip of the road: {}\n", friction);
  if (vehicle != command.vehicle_path) fmt::print("corrected car: {}\n", vehicle);
  if (!findings.findings.empty())
    for (const explain::HeldOut& h : findings.findings.front().held_out)
      if (h.whole_car && h.channel == "vx_mps")
        fmt::print("vx after {} s, whole car, laps left out: {:.3g} m/s before, {:.3g} after; nothing changes: {:.3g}\n", h.horizon_s, h.rmse_before, h.rmse_after, h.trivial_rmse);
  if (findings.simulated_lap_before_s > 0 && findings.simulated_lap_after_s > 0)
    fmt::print("lap of the built-in driver: {:.2f} s before, {:.2f} s after\n", findings.simulated_lap_before_s, findings.simulated_lap_after_s);
  fmt::print("{0}/report.html, {0}/findings.json\n", command.out_path);
  if (!findings.findings.empty()) {
    std::string recordings;
    // The stated mass is then that of the whole car.
    const bool fuel_logged = logs.front().present[explain::kFuel] && command.fuel_kg == 0;
    const std::string fuel = fmt::format(" --fuel-kg {:.6g}", fuel_kg);
    for (const std::string& path : command.recording_paths) recordings += " " + path;
    fmt::print("simulate with the corrections: crgdrive lap --track {} --vehicle {}{}{} -o {}/lap.csv\n", track, vehicle, fuel_logged ? "" : fuel, friction.empty() ? "" : " --friction " + friction, command.out_path);
    fmt::print("look again: crgexplain run --track {}{} --vehicle {}{} --recordings{}{} -o {}/again\n", track, friction.empty() ? "" : " --friction " + friction, vehicle,
               fuel_kg > 0 ? fuel : "", recordings, again, command.out_path);
  }
  return 0;
}

}  // namespace crgexplain
