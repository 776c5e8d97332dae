#include "identify/forces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "base/error.h"
#include "base/json_text.h"
#include "base/one_line.h"
#include "base/output_set.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "commands.h"
#include "identify/measure.h"
#include "vehicle/road_file.h"
#include "vehicle/vehicle_file.h"

namespace crgidentify {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// A vehicle file has no prior for how its tyres roll: they may do so by another law altogether.
constexpr double kRollingSd = 1.0;

constexpr const char* kEnding = "_forces.csv";

/// NAME_forces.csv for each log; throws base::Error where two logs have one name.
std::vector<std::string> names_of(const ForcesCommand& command) {
  std::vector<std::string> out;
  std::set<std::string> used;
  for (const std::string& path : command.recording_paths) {
    const std::string name = fs::path(path).stem().string() + kEnding;
    if (!used.insert(name).second)
      throw base::Error(fmt::format(
          "two logs would be written to {}: give them other names, or other folders", name));
    out.push_back(name);
  }
  return out;
}

/// Forces of other logs that lie in the folder: they stay, unless a killed run left them half.
std::vector<std::string> made_before(const std::string& folder,
                                     const std::vector<std::string>& now) {
  std::vector<std::string> out;
  try {
    if (const auto files = base::files_of_set(folder))
      for (const auto& [name, sha256] : *files)
        if (name.ends_with(kEnding) && std::find(now.begin(), now.end(), name) == now.end() &&
            fs::is_regular_file(fs::path(folder) / name))
          out.push_back(name);
  } catch (const base::Error&) {
  }
  return out;
}

/// Largest size and root mean square of the standard deviation.
std::pair<double, double> size_of(const identify::Estimated& e) {
  double most = 0.0, square = 0.0;
  std::size_t rows = 0;
  for (std::size_t k = 0; k < e.value.size(); ++k) {
    if (!std::isfinite(e.value[k])) continue;
    most = std::max(most, std::abs(e.value[k]));
    square += e.sd[k] * e.sd[k];
    ++rows;
  }
  return {most, std::sqrt(square / static_cast<double>(std::max<std::size_t>(1, rows)))};
}

struct ForceLine {
  std::string name, unit;
  const identify::Estimated* e;
};

std::vector<ForceLine> force_lines(const identify::Forces& f) {
  std::vector<ForceLine> out;
  for (std::size_t a = 0; a < 2; ++a)
    for (const auto& c : identify::kAxleColumns)
      out.push_back({std::string(c.name) + recording::kAxleNames[a], c.unit, &(f.*c.of)[a]});
  for (std::size_t i = 0; i < vehicle::kWheels; ++i)
    for (const auto& c : identify::kWheelColumns)
      out.push_back({std::string(c.name) + recording::kWheelNames[i], c.unit, &(f.wheel[i].*c.of)});
  for (const auto& c : identify::kCarColumns) out.push_back({c.name, c.unit, &(f.*c.of)});
  return out;
}

std::string rows_left_out(const identify::Forces& f) {
  return rows_said({{f.slow, "too slow"},
                    {f.unsettled, "at the begin of a stretch"},
                    {f.lost, "where the simulated car could not follow"}});
}

/// The mass that all forces are proportional to, and who says so.
std::string mass_said(const ForcesCommand& command, const identify::Forces& f) {
  return fmt::format("mass {:.1f} kg at the begin: {:.1f} by {}, and {:.1f} of fuel by {}",
                     f.dry_kg + f.fuel_kg, f.dry_kg,
                     command.setup_path.empty() && command.settings.empty()
                         ? "the vehicle file"
                         : "vehicle file, --setup and --set",
                     f.fuel_kg,
                     f.fuel_recorded   ? "the log's fuel_kg"
                     : command.fuel_kg ? "--fuel-kg"
                                       : kFuelAssumed);
}

std::string forces_said(const ForcesCommand& command, const std::string& log,
                        const std::string& written, const identify::Forces& f) {
  std::string out = fmt::format("{}: forces for {} of {} rows{}\n", log, f.rows, f.time_s.size(),
                                rows_left_out(f));
  out += fmt::format("  {}\n", mass_said(command, f));
  for (const std::string& remark : f.remarks) out += fmt::format("  {}\n", remark);
  if (f.off_road > 0)
    out += fmt::format("  {} rows with a wheel beside the road or over a hole\n", f.off_road);
  out += fmt::format("{:34} {:>10} {:>12}\n", "", "largest", "sd (rms)");
  for (const ForceLine& line : force_lines(f)) {
    const auto [most, sd] = size_of(*line.e);
    out += fmt::format("{:34} {:10.4g} {:12.3g} {}\n", line.name, most, sd, line.unit);
  }
  out += fmt::format("{:34} {:>10} {:>12}\n", "what parts differ by from the files", "mean",
                     "about it");
  for (const identify::PartUse& part : f.parts)
    out += fmt::format("{:34} {:9.1f}% {:11.1f}%\n", part.part, 100.0 * part.mean,
                       100.0 * part.freedom);
  out += fmt::format("{:34} {:>10} {:>12}\n", "what is taken as stated", "", "may be off");
  for (const identify::StatedUse& s : f.stated)
    out += fmt::format("{:34} {:>10} {:11.1f}%\n", s.name, "", 100.0 * s.sd);
  out += "what the columns rest on:\n";
  for (const auto& [columns, basis] : forces_basis(f))
    out += fmt::format("  {}: {}\n", columns, basis);
  for (const std::string& doubt : f.doubts) out += fmt::format("not to be used: {}\n", doubt);
  return out + fmt::format("-> {}\n", written);
}

ordered_json numbers(const ForcesCommand& command, const std::string& log,
                     const std::string& written, const identify::Forces& f) {
  ordered_json out{{"log", log},
                   {"forces", written},
                   {"rows", f.rows},
                   {"rows_of_log", f.time_s.size()},
                   {"slow", f.slow},
                   {"unsettled", f.unsettled},
                   {"lost", f.lost},
                   {"off_road", f.off_road},
                   {"wild", f.wild},
                   {"measurements", f.measurements},
                   {"mass_kg", f.dry_kg + f.fuel_kg},
                   {"fuel_kg", f.fuel_kg},
                   {"mass_from", mass_said(command, f)},
                   {"remarks", f.remarks},
                   {"doubts", f.doubts},
                   {"quantities", ordered_json::array()}};
  for (const ForceLine& line : force_lines(f)) {
    const auto [most, sd] = size_of(*line.e);
    out["quantities"].push_back(
        {{"name", line.name}, {"unit", line.unit}, {"largest", most}, {"sd_rms", sd}});
  }
  for (const identify::PartUse& part : f.parts)
    out["parts"].push_back({{"part", part.part}, {"mean", part.mean}, {"freedom", part.freedom}});
  for (const identify::StatedUse& s : f.stated)
    out["stated"].push_back({{"name", s.name}, {"sd", s.sd}});
  for (const identify::ChannelUse& c : f.channels)
    out["channels"].push_back({{"channel", c.channel}, {"rows", c.rows}, {"noise", c.noise}});
  for (const auto& [columns, basis] : forces_basis(f))
    out["basis"].push_back({{"columns", columns}, {"rests_on", basis}});
  return out;
}

std::string file_text(const ForcesCommand& command, const std::string& log,
                      const identify::Forces& f) {
  std::string out = "# crgidentify forces\n";
  std::vector<std::string> from{log, command.vehicle_path, command.track_path};
  for (const std::string& path : {command.friction_path, command.mapping_path, command.setup_path})
    if (!path.empty()) from.push_back(path);
  for (const std::string& path : from)
    out += fmt::format("# from {} sha256 {}\n", base::one_line(path), base::sha256_of_file(path));
  for (const std::string& setting : command.settings)
    out += fmt::format("# set {}\n", base::one_line(setting));
  out += fmt::format("# {}\n", mass_said(command, f));
  for (const auto& [columns, basis] : forces_basis(f))
    out += fmt::format("# {}: {}\n", columns, basis);
  for (const std::string& doubt : f.doubts)
    out += fmt::format("# not to be used: {}\n", base::one_line(doubt));
  return out + recording::format_table(forces_table(f), 7);
}

}  // namespace

int forces(const ForcesCommand& command, Terminal& terminal) {
  terminal.start("reading");
  const std::vector<std::string> written = names_of(command);
  const vehicle::Vehicle v =
      vehicle::read_vehicle(command.vehicle_path, command.setup_path, command.settings);
  const vehicle::Car<double> car = make_car(v.files, v.parameters, v.terms, v.contact);
  const vehicle::RoadFiles road = vehicle::read_road(command.track_path, command.friction_path);
  if (!road.remark.empty()) terminal.remark(road.remark);
  recording::Mapping mapping;
  if (!command.mapping_path.empty()) mapping = recording::read_mapping(command.mapping_path);
  identify::ForcesOptions options = command.options;
  options.fuel_kg = command.fuel_kg.value_or(identify::kAssumedFuel_kg);
  options.imu_ahead_m = mapping.imu_ahead_m;
  options.imu_yaw_rad = mapping.imu_yaw_rad;
  options.prior = v.prior;
  options.rolling_sd = kRollingSd;
  options.progress = terminal.progress();
  bool doubted = false;
  ordered_json json = ordered_json::array();
  std::string said;
  base::OutputSet outputs(command.out_path, "crgidentify forces");
  for (std::size_t i = 0; i < written.size(); ++i) {
    const std::string& log = command.recording_paths[i];
    const recording::Recording recording = recording::read_recording(log, mapping);
    const identify::Forces f = [&] {
      try {
        return identify::estimate_forces(car, vehicle::Road(road.surface), recording, options);
      } catch (const base::Error& e) {
        throw base::Error(fmt::format("{}: {}", log, e.what()));
      }
    }();
    doubted = doubted || !f.doubts.empty();
    base::write_file(outputs.staged(written[i]), file_text(command, log, f));
    const std::string path = outputs.path(written[i]);
    if (terminal.json)
      json.push_back(numbers(command, log, path, f));
    else
      said += forces_said(command, log, path, f);
  }
  outputs.commit("forces", made_before(command.out_path, written));
  terminal.print(terminal.json ? base::json_text(json) : said);
  return doubted ? command::kNotValid : kOk;
}

}  // namespace crgidentify
