#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "defects.h"

namespace road {

std::vector<Finding> find_folds(const HeightMap& map) {
  const std::vector<RowExtent> extents = row_extents(map);
  const double step_m = map.line.u_step_m;
  std::vector<double> depth_m(map.rows(), 0.0);
  for (std::size_t i = 0; i + 1 < map.rows(); ++i) {
    if (extents[i].empty() || extents[i + 1].empty()) continue;
    const double heading = map.line.heading_rad[i + 1];
    const double c = std::cos(heading), s = std::sin(heading);
    for (const std::size_t j : {std::max(extents[i].first, extents[i + 1].first),
                                std::min(extents[i].last, extents[i + 1].last)}) {
      const double v_m = map.v_m[j];
      const crg::Point2 a = crg::node_position(map.line, i, v_m),
                        b = crg::node_position(map.line, i + 1, v_m);
      const double advance_m = (b.x_m - a.x_m) * c + (b.y_m - a.y_m) * s;
      // The advance shrinks linearly with v: it is the step at v = 0 and nothing at the fold.
      if (advance_m < 0.0)
        depth_m[i] = std::max(depth_m[i], std::abs(v_m) * -advance_m / (step_m - advance_m));
    }
  }
  std::vector<Finding> found;
  const auto gap = static_cast<std::size_t>(std::ceil(1.0 / step_m));
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    if (!(depth_m[i] > 0.0)) continue;
    std::size_t last = i;
    double deepest = depth_m[i];
    for (std::size_t k = i; k < depth_m.size() && k <= last + gap; ++k) {
      if (!(depth_m[k] > 0.0)) continue;
      last = k;
      deepest = std::max(deepest, depth_m[k]);
    }
    found.push_back(finding(
        map, "fold", map.u_of(i), map.u_of(last + 1), deepest, "m", Severity::error,
        fmt::format(
            "The grid folds over itself from u = {:.1f} m to {:.1f} m: the bend is tighter than "
            "the road is wide by up to {:.2f} m; trim v there or move the reference line outwards",
            map.u_of(i), map.u_of(last + 1), deepest)));
    i = last;
  }
  return found;
}

}  // namespace road
