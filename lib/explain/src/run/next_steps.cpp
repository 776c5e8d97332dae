#include <fmt/format.h>

#include <algorithm>

#include "base/shell_word.h"
#include "run_steps.h"

namespace explain {
namespace {

std::string option(const char* name, const std::string& path) {
  return path.empty() ? "" : fmt::format(" {} {}", name, base::shell_word(path));
}

}  // namespace

std::vector<NextStep> next_steps(const ExplainRequest& request, const ExplainedFiles& result) {
  const CorrectedFiles& now = result.corrected;
  const bool corrected = now.track_path != request.track_path ||
                         now.friction_path != request.friction_path ||
                         now.vehicle_path != request.vehicle_path || now.mapping;
  const std::vector<Finding>& findings = result.findings.findings;
  if (!corrected && findings.empty()) return {};
  if (!corrected) {
    const auto held_back = std::find_if(findings.begin(), findings.end(),
                                        [](const Finding& f) { return !f.not_used.empty(); });
    return {{"no inputs are written", held_back != findings.end()
                                          ? held_back->not_used
                                          : "no road, car or mapping holds what was found"}};
  }
  const std::string track = option("--road", now.track_path),
                    vehicle = option("--car", now.vehicle_path),
                    friction = option("--grip", now.friction_path),
                    fuel = fmt::format(" --fuel-kg {:.6g}", now.fuel_kg);
  std::string logs;
  for (const std::string& path : request.recording_paths) logs += " " + base::shell_word(path);
  return {{"simulate with the corrections",
           fmt::format("crgdrive lap{}{}{}{}{}", track, vehicle, result.fuel_logged ? "" : fuel,
                       friction, option("-o", request.out_path + "/lap.csv"))},
          {"look again",
           fmt::format("crgexplain run{}{}{}{} --log{}{}{}", track, friction, vehicle,
                       now.fuel_kg > 0 ? fuel : "", logs, option("--mapping", now.mapping_path),
                       option("-o", request.out_path + "/again"))}};
}

}  // namespace explain
