// Cross-sections of a road, measured on its surface. Private to trace_centreline.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "mesh/ray_surface.h"

namespace road {

constexpr double kGapAlong_m = 12.0;  ///< a missing piece of road shorter than this does not end it
constexpr double kMinWidth_m = 2.0;
constexpr double kMaxWidth_m = 60.0;
constexpr double kMaxHalfWidth_m = 40.0;
constexpr double kLayerReach_m = 1.0;  ///< the road goes on where z continues within this

inline Eigen::Vector2d left_of(const Eigen::Vector2d& direction) {
  return {-direction.y(), direction.x()};
}

/// Radians, counter-clockwise.
inline double angle_between(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  return std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
}

/// Where a walk across the road stands: the middle and the two edges.
struct Station {
  Eigen::Vector3d centre, left, right;
  Eigen::Vector2d heading;
  double width_m() const { return (left - right).head<2>().norm(); }
};

/// Stations along a road; closed when it comes back to its start.
struct Walk {
  std::vector<Station> stations;
  bool closed = false;
  double area_m2 = 0.0;
  double length_m = 0.0;
};

/// Where the surface ends from `from` along `direction`; narrow cracks and holes are crossed.
Eigen::Vector3d find_edge(const RaySurface& surface, const Eigen::Vector3d& from,
                          const Eigen::Vector2d& direction, double max_m);

/// The cross-section of the road through `p`, square to `heading`, moved to its middle.
Station cross_section(const RaySurface& surface, const Eigen::Vector3d& p,
                      const Eigen::Vector2d& heading, double max_left_m = kMaxHalfWidth_m,
                      double max_right_m = kMaxHalfWidth_m);

/// Sets length and area.
void measure(Walk& walk);

}  // namespace road
