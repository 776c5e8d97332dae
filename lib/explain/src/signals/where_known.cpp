#include "where_known.h"

#include <algorithm>
#include <cmath>

#include "base/statistics.h"

namespace explain {
namespace {

constexpr std::size_t kAround = 4;  ///< steps to both sides

/// Where it holds, and around.
template <typename Holds>
std::vector<bool> holds_around(const Signals& s, const Holds& holds) {
  std::vector<bool> out(s.n, true);
  for (std::size_t i = 0; i < s.n; ++i)
    for (std::size_t k = i > kAround ? i - kAround : 0; k < std::min(s.n, i + kAround + 1); ++k)
      out[i] = out[i] && holds(k);
  return out;
}

}  // namespace

std::vector<bool> where_driven(const Signals& s) {
  if (!s.present[kThrottle] || s.present[kBrakeFront])
    return std::vector<bool>(s.n, s.present[kThrottle]);
  constexpr double kPushing = 0.15;  // nobody brakes beside so much throttle
  return holds_around(s, [&](std::size_t k) { return s.x[kThrottle][k] > kPushing; });
}

std::vector<bool> where_pushed_as_led(const Signals& s, const std::vector<bool>& driven) {
  if (s.present[kThrottle]) return driven;
  // What the log alone says: how fast the speed changes.
  constexpr double kLittle_mps2 = 1.0;
  return holds_around(s, [&](std::size_t k) {
    const double faster_mps2 = s.dx[kVx][k];
    return !(faster_mps2 > kLittle_mps2) &&
           (s.present[kBrakeFront] || !(faster_mps2 < -kLittle_mps2));
  });
}

std::vector<bool> where_slip_known(const Signals& s) {
  constexpr double kStraight_radps = 0.05;
  std::vector<bool> out(s.n, s.present[kVy] || s.present[kYaw]);
  for (std::size_t i = 0; i < s.n; ++i) {
    const double yaw_radps = s.present[kYawRate] ? s.x[kYawRate][i] : s.dx[kYaw][i];
    out[i] = out[i] || std::abs(yaw_radps) < kStraight_radps;
  }
  return out;
}

std::vector<bool> where_spinning(const Signals& s, double track_m) {
  constexpr double kMost = 0.06;
  std::vector<bool> out(s.n, false);
  if (!s.present[kWheelRear]) return out;
  std::vector<double> radius_m;
  for (std::size_t i = 0; i < s.n; ++i)
    if (s.x[kVx][i] > 6.0 && std::isfinite(s.x[kWheelRear][i]))
      radius_m.push_back(s.x[kVx][i] / s.x[kWheelRear][i]);
  const double radius = base::median_or(1.0, std::move(radius_m));
  for (std::size_t i = 0; i < s.n; ++i) {
    const double v = s.x[kVx][i], r = s.present[kYawRate] ? s.x[kYawRate][i] : s.dx[kYaw][i];
    const double apart = s.present[kWheelRearDifference] ? s.x[kWheelRearDifference][i] : 0.0;
    for (const double left : {-1.0, 1.0}) {  // 1: the left wheel
      const double wheel = s.x[kWheelRear][i] + 0.5 * left * apart;
      const double over_ground = v - 0.5 * left * track_m * (std::isfinite(r) ? r : 0.0);
      out[i] = out[i] || wheel * radius > (1 + kMost) * over_ground;
    }
  }
  return out;
}

}  // namespace explain
