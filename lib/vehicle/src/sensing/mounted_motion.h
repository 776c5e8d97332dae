// What a box feels that sits somewhere in the car, with axes of its own. Private.
#pragma once

#include <array>

#include "vehicle/vec3.h"

namespace vehicle {

/// Of one point of the car, in the body's axes; the place in the map's.
struct PointMotion {
  Vec3<double> place_m;
  std::array<double, 3> angle_rad{};  ///< roll, pitch, yaw
  Vec3<double> speed_mps, turning_radps, acceleration_mps2;
};

/// The same `arm_m` from there (body axes), in axes that are turned by roll, pitch, yaw against the
/// body's. `turning_change_radps2`: how fast the turning changes.
PointMotion mounted(const PointMotion& car, const std::array<double, 3>& turning_change_radps2,
                    const std::array<double, 3>& arm_m, const std::array<double, 3>& turned_rad);

}  // namespace vehicle
