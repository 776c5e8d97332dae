// When a road must not be used.
#include <fmt/format.h>

#include "make/summary.h"

namespace road {
namespace {

// Of some ten thousand random points a few more may fall into closed holes and gaps than their area
// says.
constexpr double kScatter = 1.5;

}  // namespace

ValidateLimits limits_of(const BuildSummary& summary) {
  ValidateLimits limits = summary.recipe.limits;
  const double length_m = summary.centreline.length_m, width_m = summary.centreline.width_median_m;
  if (length_m > 0.0)
    limits.max_share_without_mesh += kScatter * summary.clean.bridged_m / length_m;
  if (length_m > 0.0 && width_m > 0.0)
    limits.max_share_without_mesh +=
        kScatter * summary.clean.holes_closed_m2 / (length_m * width_m);
  return limits;
}

std::vector<std::string> validation_failures(const ValidateReport& report,
                                             const ValidateLimits& limits) {
  std::vector<std::string> failures;
  if (report.road_points == 0) {
    failures.push_back(
        "no point of the file could be compared with the mesh: do the file and the mesh share a "
        "frame?");
    return failures;
  }
  if (!(report.road_error_p99_m <= limits.max_z_error_p99_m))
    failures.push_back(fmt::format(
        "1 % of the points of the road are more than {:.4g} m from the mesh, at most {:.4g} m "
        "wanted; the worst is {:.4g} m at u = {:.2f} m, v = {:.2f} m",
        report.road_error_p99_m, limits.max_z_error_p99_m, report.z_error_m.max, report.worst_u_m,
        report.worst_v_m));
  const double share = static_cast<double>(report.road_points_without_mesh) /
                       static_cast<double>(report.road_points + report.road_points_without_mesh);
  if (share > limits.max_share_without_mesh)
    failures.push_back(fmt::format(
        "{} of {} points of the road have a height where the mesh has no surface",
        report.road_points_without_mesh, report.road_points + report.road_points_without_mesh));
  if (!(report.seam_z_step_m <= limits.max_seam_z_step_m))
    failures.push_back(
        fmt::format("the height steps by {:.4g} m at the seam, at most {:.4g} m wanted",
                    report.seam_z_step_m, limits.max_seam_z_step_m));
  failures.insert(failures.end(), report.doubts.begin(), report.doubts.end());
  return failures;
}

}  // namespace road
