#include "stations.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kProbeStep_m = 0.5;  // across the road, refined to kEdgeResolution_m at its end
constexpr double kEdgeResolution_m = 1e-3;
constexpr double kGapAcross_m = 1.5;  // a crack or hole narrower than this does not end the road
constexpr double kCrack_m = 0.75;     // what is wider than this, and open this far before and
constexpr double kHole_m = 6.0;       // behind, parts the road from another leg beside it

}  // namespace

/// Walks from `from` along `direction` until the surface ends; gaps up to kGapAcross_m are crossed,
/// but not those between two legs that run side by side.
Vector3d find_edge(const RaySurface& surface, const Vector3d& from, const Vector2d& direction,
                   double max_m) {
  Vector3d last = from;
  double last_m = 0.0, slope = 0.0;
  const auto probe = [&](double at_m) -> std::optional<Vector3d> {
    const Vector2d xy = from.head<2>() + at_m * direction;
    const double z_predicted = last.z() + slope * (at_m - last_m);
    const auto hit = surface.nearest_hit(xy.x(), xy.y(), z_predicted, kLayerReach_m);
    if (!hit) return std::nullopt;
    return Vector3d(xy.x(), xy.y(), hit->z_m);
  };
  const auto accept = [&](double at_m, const Vector3d& p) {
    if (at_m - last_m > 0.1) slope = std::clamp((p.z() - last.z()) / (at_m - last_m), -1.5, 1.5);
    last = p;
    last_m = at_m;
  };
  const auto is_between_legs = [&](double to_m) {
    const double middle_m = 0.5 * (last_m + to_m);
    const Vector2d middle = from.head<2>() + middle_m * direction, along = left_of(direction);
    const double z_m = last.z() + slope * (middle_m - last_m);
    for (const double s_m : {-kHole_m, 0.0, kHole_m}) {
      const Vector2d xy = middle + s_m * along;
      if (surface.nearest_hit(xy.x(), xy.y(), z_m, kLayerReach_m)) return false;
    }
    return true;
  };
  for (double at_m = kProbeStep_m; at_m <= max_m; at_m += kProbeStep_m) {
    if (const auto p = probe(at_m)) {
      if (at_m - last_m > kCrack_m + kProbeStep_m && is_between_legs(at_m)) break;
      accept(at_m, *p);
    } else if (at_m - last_m > kGapAcross_m) {
      break;
    }
  }
  double inside_m = last_m, outside_m = last_m + kProbeStep_m;
  while (outside_m - inside_m > kEdgeResolution_m) {
    const double middle_m = 0.5 * (inside_m + outside_m);
    if (const auto p = probe(middle_m)) {
      inside_m = middle_m;
      last = *p;
    } else {
      outside_m = middle_m;
    }
    if (inside_m != last_m && inside_m == middle_m) last_m = inside_m;
  }
  return last;
}

/// The cross-section of the road through `p`, square to `heading`, moved to its middle.
Station cross_section(const RaySurface& surface, const Vector3d& p, const Vector2d& heading,
                      double max_left_m, double max_right_m) {
  const Vector2d normal = left_of(heading);
  Station station;
  station.heading = heading;
  station.left = find_edge(surface, p, normal, max_left_m);
  station.right = find_edge(surface, p, -normal, max_right_m);
  const Vector2d middle = 0.5 * (station.left + station.right).head<2>();
  const double z_guess = 0.5 * (p.z() + 0.5 * (station.left.z() + station.right.z()));
  const auto hit = surface.nearest_hit(middle.x(), middle.y(), z_guess, 2.0 * kLayerReach_m);
  station.centre = {middle.x(), middle.y(), hit ? hit->z_m : z_guess};
  return station;
}

void measure(Walk& walk) {
  walk.length_m = walk.area_m2 = 0.0;
  for (std::size_t i = 0; i + 1 < walk.stations.size(); ++i) {
    const double step_m = (walk.stations[i + 1].centre - walk.stations[i].centre).head<2>().norm();
    walk.length_m += step_m;
    walk.area_m2 += step_m * walk.stations[i].width_m();
  }
}

}  // namespace road
