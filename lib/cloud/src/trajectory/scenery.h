// What stands beside a road in made-up scans: trees, poles and walls. And boxes, as cars are.
#pragma once

#include <Eigen/Core>

#include "base/random.h"
#include "cloud/road_frame.h"

namespace cloud {

/// Upright, turned about the vertical.
struct Box {
  Eigen::Vector3d middle_m;
  Eigen::Vector2d heading;
  Eigen::Vector3d half_m;
};

/// Distance along a ray (of length 1); infinite where it passes by.
double distance_to(const Box& box, const Eigen::Vector3d& from, const Eigen::Vector3d& along);

/// An upright round body; with leaves a ray goes in by 0.3 m on average before it meets one.
struct Round {
  Eigen::Vector3d foot_m;  ///< on its axis, at its lower end
  double radius_m = 0.0, height_m = 0.0;
  bool leaves = false;
};

struct Scenery {
  std::vector<Round> rounds;  ///< poles, trunks, crowns
  std::vector<Box> walls;
};

/// A tree, a pole or a wall on each side of the road about every `every_m`, 1 to 3.5 m beyond
/// `from_m` beside the middle, where the road's surface reaches. The same for the same seed.
Scenery scenery_along(const RoadFrame& frame, double every_m, double from_m, std::uint64_t seed);

/// What of it may lie within a range of a place.
Scenery near_of(const Scenery& all, const Eigen::Vector3d& place_m, double range_m);

/// Distance along a ray to the nearest of it; infinite where it meets nothing.
double distance_to(const Scenery& scenery, const Eigen::Vector3d& from,
                   const Eigen::Vector3d& along, base::Random& random);

}  // namespace cloud
