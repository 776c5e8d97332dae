// How a recording turned, by its gyro and on the map.
#include <cmath>
#include <limits>
#include <numbers>

#include "explain/banking_by_turning.h"

namespace explain {
namespace {

/// Course of the path less the logged side slip, without jumps; NaN where it stands.
std::vector<double> course_of(const Signals& s, bool with_slip) {
  constexpr double kSlow_mps = 3.0;
  std::vector<double> out(s.n, std::numeric_limits<double>::quiet_NaN());
  double last = 0.0;
  for (std::size_t i = 0; i < s.n; ++i) {
    const double x_mps = s.dx[kX][i], y_mps = s.dx[kY][i];
    if (!(std::hypot(x_mps, y_mps) > kSlow_mps)) continue;
    const double slip = with_slip ? std::atan2(s.x[kVy][i], s.x[kVx][i]) : 0.0;
    const double now = std::atan2(y_mps, x_mps) - slip;
    if (!std::isfinite(now)) continue;
    last += std::remainder(now - last, 2 * std::numbers::pi);
    out[i] = last;
  }
  return out;
}

}  // namespace

const char* name_of(TurningBy by) {
  constexpr const char* kNames[] = {"nothing", "yaw rate and heading",
                                    "yaw rate, positions and side slip", "yaw rate and positions"};
  return kNames[static_cast<std::size_t>(by)];
}

Turning turning_of(const Signals& s) {
  Turning out;
  if (!s.present[kYawRate]) return out;
  out.by = s.present[kYaw]  ? TurningBy::kHeading
           : s.present[kVy] ? TurningBy::kCourseAndSlip
                            : TurningBy::kCourse;
  out.gyro_radps = s.x[kYawRate];
  out.dgyro_radps2 = s.dx[kYawRate];
  out.turned_rad =
      out.by == TurningBy::kHeading ? s.x[kYaw] : course_of(s, out.by == TurningBy::kCourseAndSlip);
  for (std::size_t i = 0; i < s.n; ++i)
    out.cosine.push_back(1 /
                         std::sqrt((1 + s.bank[i] * s.bank[i]) * (1 + s.grade[i] * s.grade[i])));
  out.bank = s.bank;
  out.grade = s.grade;
  out.u_m = s.u_m;
  out.v_m = s.v_m;
  out.speed_mps = s.x[kVx];
  out.lap = s.lap;
  return out;
}

}  // namespace explain
