#include "check_sampling.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mesh/error.h"

namespace road {
namespace {

/// Rays are cast in float32 about the surface's origin.
void refuse_coarse_floats(const crg::ReferenceLine& line, const RaySurface& surface,
                          double step_m) {
  double farthest_m = 0.0;
  for (std::size_t i = 0; i < line.size(); ++i)
    farthest_m = std::max({farthest_m, std::abs(line.x_m[i] - surface.origin_m().x()),
                           std::abs(line.y_m[i] - surface.origin_m().y())});
  const auto single = static_cast<float>(farthest_m);
  const double spacing_m =
      static_cast<double>(std::nextafter(single, std::numeric_limits<float>::infinity()) - single);
  if (step_m >= 10.0 * spacing_m) return;
  throw Error(fmt::format(
      "steps of {:.3g} m, {:.0f} m from the middle of the mesh, where float32 resolves {:.3g} m; "
      "wanted steps of at "
      "least ten times that: take larger ones (--u-step-m, --v-step-m) or split the mesh",
      step_m, farthest_m, spacing_m));
}

void refuse_narrow(const Centreline& centreline, double least_m) {
  double u = 0.0;
  for (std::size_t i = 0; i < centreline.points_m.size(); ++i) {
    if (i > 0) u += (centreline.points_m[i] - centreline.points_m[i - 1]).norm();
    const double width_m =
        i < centreline.half_width_m.size() ? 2.0 * centreline.half_width_m[i] : least_m;
    if (width_m >= least_m) continue;
    throw Error(
        fmt::format("the road is {:.3g} m wide near u = {:.1f} m; wanted at least two steps "
                    "across, {:.3g} m; take a smaller "
                    "--v-step-m",
                    width_m, u, least_m));
  }
}

}  // namespace

void check_sampling(const crg::ReferenceLine& line, const Centreline& centreline,
                    const RaySurface& surface, const SampleOptions& options) {
  const double v_step_m = *options.v_step_m;
  if (line.size() < 2) throw Error("the reference line has fewer than two nodes");
  if (centreline.points_m.size() < 2) throw Error("the centreline has fewer than two stations");
  if (!(v_step_m > 0.0) || !(options.v_max_m >= v_step_m)) {
    throw Error(fmt::format("v_step_m is {} and v_max_m is {}; wanted 0 < v_step_m <= v_max_m",
                            v_step_m, options.v_max_m));
  }
  const double nodes =
      static_cast<double>(line.size()) * (2.0 * std::floor(options.v_max_m / v_step_m) + 1.0);
  if (nodes > static_cast<double>(options.max_nodes)) {
    throw Error(fmt::format(
        "the grid would have {:.3g} nodes, more than the limit of {:.3g}; take larger steps "
        "(--u-step-m, --v-step-m), a smaller --v-max-m, or raise max_nodes",
        nodes, static_cast<double>(options.max_nodes)));
  }
  refuse_coarse_floats(line, surface, std::min(line.u_step_m, v_step_m));
  refuse_narrow(centreline, 2.0 * v_step_m);
}

}  // namespace road
