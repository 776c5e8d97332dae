#include <fmt/format.h>

#include "commands.h"

namespace lidar2mesh {
namespace {

void print_result(const MapCommand& command, const cloud::Refined& refined, Terminal& terminal) {
  const cloud::MapReport& facts = refined.facts;
  terminal.print(fmt::format("{} points read, {} used; {:.1f} % of the nodes come from points\n",
                             facts.points, facts.used, 100.0 * facts.coverage));
  if (command.correct_drift) {
    terminal.print(
        fmt::format("drift: {} after {} rounds over {} sections in {} passes\n",
                    facts.converged ? "converged"
                    : command.base.empty()
                        ? fmt::format("still moving by {:.1f} mm a round", 1e3 * facts.last_move_m)
                        : "NOT converged",
                    facts.iterations, facts.sections, facts.passes));
    if (command.base.empty())
      terminal.print(
          fmt::format("where the road lies is the trajectory's word: about {:.0f} mm in height\n",
                      1e3 * facts.typical_stddev[2]));
    if (!command.base.empty())
      terminal.print(fmt::format(
          "against the base {:.1f} -> {:.1f} mm, {:.0f} % of its cells believed\n",
          1e3 * facts.rms_before_m, 1e3 * facts.rms_after_m, 100.0 * facts.inlier_share));
    if (facts.passes > 1)
      terminal.print(fmt::format("between passes {:.1f} -> {:.1f} mm\n",
                                 1e3 * facts.pass_rms_before_m, 1e3 * facts.pass_rms_after_m));
    if (facts.left_out_nodes > 0)
      terminal.print(fmt::format(
          "one pass left out: 90 % intervals held {:.1f} % of its {} nodes; the points' own "
          "deviations were multiplied by {:.2f}\n",
          100.0 * facts.left_out_within_90, facts.left_out_nodes, facts.noise_factor));
    for (const std::string& direction : facts.unfixed)
      terminal.print(fmt::format(
          "note: {} is hardly fixed by the data (typical deviation in summary.json)\n", direction));
  }
  terminal.print(
      fmt::format("heights changed by {:.1f} mm (median), {:.1f} mm (99 %), {:.1f} mm at most\n",
                  1e3 * facts.changed_p50_m, 1e3 * facts.changed_p99_m, 1e3 * facts.changed_max_m));
  for (const std::string& remark : facts.remarks)
    terminal.print(fmt::format("note: {}\n", one_line(remark)));
  terminal.print(fmt::format("road     {}\nsummary  {}\n", refined.crg_path, refined.summary_path));
}

}  // namespace

int show_map(const MapCommand& command, const cloud::Refined& refined, Terminal& terminal) {
  if (terminal.json)
    terminal.print(refined.summary_json);
  else
    print_result(command, refined, terminal);
  if (const std::string why = cloud::why_not_usable(refined); !why.empty())
    throw command::NotValid(why);
  return kOk;
}

int run_map(const MapCommand& command, Terminal& terminal) {
  want_outliers(command.outliers);
  return show_map(command, cloud::refine(command, terminal.progress()), terminal);
}

}  // namespace lidar2mesh
