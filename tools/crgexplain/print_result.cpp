#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "commands.h"

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
  if (!f.not_used.empty())
    terminal.print(fmt::format("    seen, not used: {}\n", one_line(f.not_used)));
  for (const explain::Rival& r : f.rivals)
    if (!r.separable)
      terminal.print(fmt::format("    cannot be told from {}: {}\n", r.mechanism,
                                 one_line(r.separating_experiment)));
}

/// A channel's patterns as one: the first, and what else it goes with.
void print_unexplained(const explain::Unexplained& u, const std::string& also, Terminal& terminal) {
  std::string where;
  if (!u.where.empty())
    where = fmt::format("{} from {:.0f} to {:.0f} m", u.locked_to == "u" ? "" : ", first at u",
                        u.where[0].u_begin_m, u.where[0].u_end_m);
  terminal.print(fmt::format("  unexplained: {} over {}{}, {:.3g} {}{}\n", one_line(u.channel),
                             u.locked_to, where, u.size, u.unit, also));
}

/// A line per channel: its errors at the horizons that it was judged at.
void print_whole_car(const std::vector<explain::HeldOut>& held_out, Terminal& terminal) {
  std::vector<std::string> channels;
  for (const explain::HeldOut& h : held_out)
    if (h.whole_car && std::find(channels.begin(), channels.end(), h.channel) == channels.end())
      channels.push_back(h.channel);
  for (const std::string& channel : channels) {
    std::string horizons, unit;
    std::array<std::string, 4> errors;
    for (const explain::HeldOut& h : held_out) {
      if (!h.whole_car || h.channel != channel) continue;
      const char* comma = horizons.empty() ? "" : ", ";
      horizons += fmt::format("{}{:g}", comma, h.horizon_s);
      const std::array<double, 4> values{h.rmse_before, h.rmse_after, h.trivial_rmse, h.trend_rmse};
      for (std::size_t k = 0; k < values.size(); ++k)
        errors[k] += fmt::format("{}{:.3g}", comma, values[k]);
      unit = h.unit;
    }
    terminal.print(fmt::format(
        "whole car, laps left out, {} in {} after {} s: {} before; {} after; nothing changes: {}; "
        "trend: {}\n",
        one_line(channel), unit, horizons, errors[0], errors[1], errors[2], errors[3]));
  }
}

}  // namespace

void print_result(const RunCommand& command, const explain::ExplainedFiles& result,
                  Terminal& terminal) {
  const explain::Findings& findings = result.findings;
  const explain::CorrectedFiles& now = result.corrected;
  terminal.print(fmt::format("verdict: {}\n", explain::name_of(findings.verdict)));
  for (const explain::Finding& f : findings.findings) print_finding(f, terminal);
  std::set<std::string> said;
  for (const explain::Unexplained& u : findings.unexplained) {
    if (!said.insert(u.channel).second) continue;
    std::string also;
    for (const explain::Unexplained& other : findings.unexplained)
      if (other.channel == u.channel && other.locked_to != u.locked_to)
        also += (also.empty() ? "; also over " : ", ") + other.locked_to;
    print_unexplained(u, also, terminal);
  }
  for (const explain::Remark& remark : findings.remarks)
    terminal.print(fmt::format("  {}\n", one_line(remark.text)));
  if (now.track_path != command.track_path)
    terminal.print(fmt::format("corrected road: {}\n", now.track_path));
  if (now.friction_path != command.friction_path)
    terminal.print(fmt::format("grip of the road: {}\n", now.friction_path));
  if (now.vehicle_path != command.vehicle_path)
    terminal.print(fmt::format("corrected car: {}\n", now.vehicle_path));
  if (!findings.findings.empty()) print_whole_car(findings.findings.front().held_out, terminal);
  if (findings.simulated_lap_before_s > 0 && findings.simulated_lap_after_s > 0)
    terminal.print(fmt::format("lap of the built-in driver: {:.2f} s before, {:.2f} s after\n",
                               findings.simulated_lap_before_s, findings.simulated_lap_after_s));
  terminal.print(fmt::format("{0}/report.html, {0}/findings.json\n", command.out_path));
  for (const explain::NextStep& step : result.next)
    terminal.print(fmt::format("{}: {}\n", step.what, one_line(step.how)));
}

}  // namespace crgexplain
