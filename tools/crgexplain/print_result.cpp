#include <fmt/format.h>

#include "run_steps.h"

namespace crgexplain {
namespace {

void print_finding(const explain::Finding& f, Terminal& terminal) {
  terminal.print(fmt::format("  {}{}: {}\n", f.mechanism,
                             f.channel.empty() ? "" : " (" + one_line(f.channel) + ")", f.physics));
  for (const explain::FoundParameter& p : f.parameters)
    terminal.print(fmt::format("    {} = {:.4g} {} [{:.4g}, {:.4g}]\n", p.name, p.value, p.unit,
                               p.low, p.high));
  for (const explain::Place& w : f.where)
    terminal.print(fmt::format("    u {:.0f} to {:.0f} m\n", w.u_begin_m, w.u_end_m));
  for (const explain::Rival& r : f.rivals)
    if (!r.separable)
      terminal.print(fmt::format("    cannot be told from {}: {}\n", r.mechanism,
                                 one_line(r.separating_experiment)));
}

void print_unexplained(const explain::Unexplained& u, Terminal& terminal) {
  std::string where;
  if (!u.where.empty())
    where = fmt::format("{} from {:.0f} to {:.0f} m", u.locked_to == "u" ? "" : ", first at u",
                        u.where[0].u_begin_m, u.where[0].u_end_m);
  terminal.print(fmt::format("  unexplained: {} over {}{}, {:.3g} {}\n", one_line(u.channel),
                             u.locked_to, where, u.size, u.unit));
}

/// How the corrected inputs are simulated with, and looked at again.
void print_commands(const RunCommand& command, const Recordings& recordings, const Corrected& now,
                    Terminal& terminal) {
  const auto option = [](const char* name, const std::string& path) {
    return path.empty() ? "" : fmt::format(" {} {}", name, shell_word(path));
  };
  const std::string track = option("--track", now.track_path),
                    vehicle = option("--vehicle", now.vehicle_path),
                    friction = option("--friction", now.friction_path);
  const std::string fuel = fmt::format(" --fuel-kg {:.6g}", now.fuel_kg);
  // Without a logged fuel the stated mass is that of the whole car.
  const bool fuel_logged = recordings.logs.front().present[explain::kFuel] && command.fuel_kg == 0;
  terminal.print(fmt::format("simulate with the corrections: crgdrive lap{}{}{}{}{}\n", track,
                             vehicle, fuel_logged ? "" : fuel, friction,
                             option("-o", command.out_path + "/lap.csv")));
  std::string logs;
  for (const std::string& path : command.recording_paths) logs += " " + shell_word(path);
  terminal.print(fmt::format("look again: crgexplain run{}{}{}{} --recordings{}{}{}\n", track,
                             friction, vehicle, now.fuel_kg > 0 ? fuel : "", logs,
                             option("--mapping", now.mapping_path),
                             option("-o", command.out_path + "/again")));
}

}  // namespace

void print_result(const RunCommand& command, const Recordings& recordings,
                  const explain::Findings& findings, const Corrected& now, Terminal& terminal) {
  terminal.print(fmt::format("verdict: {}\n", explain::name_of(findings.verdict)));
  for (const explain::Finding& f : findings.findings) print_finding(f, terminal);
  for (const explain::Unexplained& u : findings.unexplained) print_unexplained(u, terminal);
  for (const explain::Remark& remark : findings.remarks)
    terminal.print(fmt::format("  {}\n", one_line(remark.text)));
  if (now.track_path != command.track_path)
    terminal.print(fmt::format("corrected road: {}\n", now.track_path));
  if (now.friction_path != command.friction_path)
    terminal.print(fmt::format("grip of the road: {}\n", now.friction_path));
  if (now.vehicle_path != command.vehicle_path)
    terminal.print(fmt::format("corrected car: {}\n", now.vehicle_path));
  if (!findings.findings.empty())
    for (const explain::HeldOut& h : findings.findings.front().held_out)
      if (h.whole_car && h.channel == "vx_mps")
        terminal.print(
            fmt::format("vx after {} s, whole car, laps left out: {:.3g} m/s before, {:.3g} after; "
                        "nothing changes: {:.3g}\n",
                        h.horizon_s, h.rmse_before, h.rmse_after, h.trivial_rmse));
  if (findings.simulated_lap_before_s > 0 && findings.simulated_lap_after_s > 0)
    terminal.print(fmt::format("lap of the built-in driver: {:.2f} s before, {:.2f} s after\n",
                               findings.simulated_lap_before_s, findings.simulated_lap_after_s));
  terminal.print(fmt::format("{0}/report.html, {0}/findings.json\n", command.out_path));
  if (!findings.findings.empty()) print_commands(command, recordings, now, terminal);
}

}  // namespace crgexplain
