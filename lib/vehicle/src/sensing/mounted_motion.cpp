#include "mounted_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace vehicle {
namespace {

Vec3<double> vec(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }

}  // namespace

PointMotion mounted(const PointMotion& car, const std::array<double, 3>& turning_change_radps2,
                    const std::array<double, 3>& arm_m, const std::array<double, 3>& turned_rad) {
  const Vec3<double> arm = vec(arm_m), &turning = car.turning_radps;
  const Rotation<double> body = rotation(car.angle_rad[0], car.angle_rad[1], car.angle_rad[2]);
  const Rotation<double> box = rotation(turned_rad[0], turned_rad[1], turned_rad[2]);
  PointMotion out = car;
  out.place_m = car.place_m + body.apply(arm);
  out.speed_mps = box.undo(car.speed_mps + cross(turning, arm));
  out.acceleration_mps2 = box.undo(car.acceleration_mps2 + cross(vec(turning_change_radps2), arm) +
                                   cross(turning, cross(turning, arm)));
  out.turning_radps = box.undo(turning);
  if (turned_rad == std::array<double, 3>{}) return out;
  // Axes of the box in the map: yaw, then pitch (nose down positive), then roll, as the body's.
  const Vec3<double> x = body.apply(box.apply({1, 0, 0})), y = body.apply(box.apply({0, 1, 0})),
                     z = body.apply(box.apply({0, 0, 1}));
  out.angle_rad[0] = std::atan2(y.z, z.z);
  out.angle_rad[1] = -std::asin(std::clamp(x.z, -1.0, 1.0));
  const double yaw = std::atan2(x.y, x.x);
  out.angle_rad[2] += std::remainder(yaw - car.angle_rad[2], 2.0 * std::numbers::pi);
  return out;
}

}  // namespace vehicle
