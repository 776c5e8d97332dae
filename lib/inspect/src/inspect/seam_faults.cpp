#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "defects.h"

namespace road {

std::vector<Finding> find_seam_faults(const HeightMap& map, const FindingOptions& options) {
  std::vector<Finding> found;
  const crg::ReferenceLine& line = map.line;
  const std::size_t n = line.size(), last = n - 1;
  if (n < 8) return found;
  const double u_begin_m = map.u_of(last - 1), u_end_m = map.u_of(last);
  const double dx = line.x_m[0] - line.x_m[last], dy = line.y_m[0] - line.y_m[last];
  const double c = std::cos(line.heading_rad[last]), s = std::sin(line.heading_rad[last]);
  const double along_m = dx * c + dy * s, across_m = -dx * s + dy * c;
  const double distance_m = std::hypot(dx, dy);
  const double turn = std::abs(
      std::remainder(line.heading_rad[1] - line.heading_rad[last], 2.0 * std::numbers::pi));
  if (!options.closed) {
    if (distance_m < std::max(1.0, 2.0 * line.u_step_m) && turn < std::numbers::pi / 3.0 &&
        u_end_m - line.u_begin_m > 100.0) {
      found.push_back(finding(
          map, "wrong_seam", u_begin_m, u_end_m, distance_m, "m", Severity::remark,
          fmt::format(
              "The road ends {:.2f} m from its start and in the same direction, but the file does "
              "not say that it is closed: a vehicle runs off its end",
              distance_m)));
    }
    return found;
  }
  if (std::abs(across_m) > options.max_seam_gap_m ||
      along_m > line.u_step_m + options.max_seam_gap_m || along_m < -options.max_seam_gap_m) {
    found.push_back(finding(map, "wrong_seam", u_begin_m, u_end_m, distance_m, "m", Severity::error,
                            fmt::format("The closed road does not close: its end lies {:.2f} m "
                                        "before and {:.2f} m beside its start",
                                        along_m, across_m)));
    return found;
  }
  double worst = 0.0;
  std::size_t one_sided = 0;
  for (std::size_t j = 0; j < map.columns(); ++j) {
    const double first = map.at(0, j), end = map.at(last, j);
    one_sided += std::isnan(first) != std::isnan(end);
    // Over a gap of up to a step the road goes on as steep as it was.
    const double slope = (end - static_cast<double>(map.at(last - 1, j))) / line.u_step_m;
    const double step = first - end - (along_m > 0.01 ? slope * along_m : 0.0);
    if (std::abs(step) > std::abs(worst)) worst = step;
  }
  if (std::abs(worst) > options.min_seam_step_m) {
    found.push_back(
        finding(map, "wrong_seam", u_begin_m, u_end_m, worst, "m",
                std::abs(worst) > options.max_seam_step_m ? Severity::error : Severity::remark,
                fmt::format("The height steps by up to {:.1f} mm where the road closes (u = {:.1f} "
                            "m back to {:.1f} m)",
                            1000.0 * std::abs(worst), u_end_m, line.u_begin_m)));
  }
  if (one_sided > 2 + map.columns() / 50) {
    found.push_back(finding(
        map, "wrong_seam", u_begin_m, u_end_m, static_cast<double>(one_sided), "1",
        Severity::remark,
        fmt::format("{} columns have a height only on one side of the place where the road closes",
                    one_sided)));
  }
  // What the line turns at the seam beyond half of what it turns at the corners before and behind.
  const auto corner = [&](double a, double b) {
    return std::remainder(b - a, 2.0 * std::numbers::pi);
  };
  const double kink = corner(line.heading_rad[last], line.heading_rad[1]) -
                      0.5 * (corner(line.heading_rad[last - 1], line.heading_rad[last]) +
                             corner(line.heading_rad[1], line.heading_rad[2]));
  if (std::abs(kink) > options.min_seam_heading_rad) {
    found.push_back(
        finding(map, "wrong_seam", u_begin_m, u_end_m, kink, "rad",
                std::abs(kink) > options.max_seam_heading_rad ? Severity::error : Severity::remark,
                fmt::format("The reference line has a kink of {:.1f} mrad where the road closes",
                            1000.0 * std::abs(kink))));
  }
  return found;
}

}  // namespace road
