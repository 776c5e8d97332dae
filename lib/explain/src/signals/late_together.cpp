#include "late_together.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "not_known.h"
#include "path_says.h"

namespace explain {
namespace {

constexpr double kLeast_s = 0.06;  ///< less is told column by column
constexpr double kAgree_s = 0.03;
constexpr double kWheels_s = 0.1;  ///< that slip are before the speed by less
constexpr double kEarly_s = 0.15;  ///< drivers and wheels that slip are before the car by less

/// The rate at which the path itself speeds up: positions alone.
std::vector<double> rate_of_path(const Signals& s) {
  std::vector<double> speed(s.n), out(s.n, kNaN);
  for (std::size_t i = 0; i < s.n; ++i) speed[i] = std::hypot(s.dx[kX][i], s.dx[kY][i]);
  constexpr std::size_t kHalf = 4;
  for (std::size_t i = kHalf; i + kHalf < s.n; ++i)
    if (speed[i] > 6)
      out[i] = (speed[i + kHalf] - speed[i - kHalf]) / (2 * kHalf * Signals::kStep_s);
  return out;
}

/// How late a channel follows the path, s; NaN where it does not follow so well that only its clock
/// can be meant. A filter is late too, but it flattens: `scaled` channels want their own size.
double late_by(const std::vector<double>& x, const std::vector<double>& path, double swing,
               bool scaled) {
  const Match m = match(x, path, swing);
  const bool follows =
      m.known && std::abs(m.correlation) > 0.9 && (!scaled || (m.slope > 0.8 && m.slope < 1.25));
  return follows ? m.lag_s : kNaN;
}

/// The same of the pressure that slows the car; other things do as well, so that it follows less.
double brakes_late_by(const Signals& s, const std::vector<double>& rate) {
  if (!s.present[kBrakeFront] || s.commanded[kBrakeFront]) return kNaN;
  std::vector<double> slowing(rate);
  for (double& r : slowing) r = -r;
  const Match m = match(s.x[kBrakeFront], slowing, 0.5);
  return m.known && m.correlation > 0.7 ? m.lag_s : kNaN;
}

bool agree(double a, double b) { return std::abs(a - b) <= kAgree_s; }

/// Columns behind a list of channels, each once.
std::vector<std::string> columns_of(const Signals& s, const std::vector<Channel>& channels) {
  std::vector<std::string> out;
  for (const Channel c : channels) {
    if (!s.present[c]) continue;
    std::istringstream names(s.column[c]);
    for (std::string name; std::getline(names, name, ',');)
      if (std::find(out.begin(), out.end(), name) == out.end()) out.push_back(name);
  }
  return out;
}

}  // namespace

std::optional<LateColumns> late_together(const Signals& s) {
  const PathSays path = path_says(s);
  const std::vector<double> rate = rate_of_path(s);
  const auto lag = [&](Channel c, const std::vector<double>& x, const std::vector<double>& from,
                       double swing, bool scaled = true) {
    return s.present[c] ? late_by(x, from, swing, scaled) : kNaN;
  };
  // These three follow a path without delay. A car's nose turns before its path, steering before
  // that: they say with whom they are late.
  const double ay = lag(kAy, s.x[kAy], path.across_mps2, 0.5), ax = lag(kAx, s.x[kAx], rate, 0.5),
               vx = lag(kVx, s.dx[kVx], rate, 0.5),
               gyro = lag(kYawRate, s.x[kYawRate], path.turn_radps, 0.02),
               heading = lag(kYaw, s.dx[kYaw], path.turn_radps, 0.02);
  double imu = std::isfinite(ay) ? ay : ax;
  if (!std::isfinite(imu) || !std::isfinite(vx) || (std::isfinite(ax) && !agree(ax, imu)))
    return std::nullopt;
  const bool heading_with_path =
      std::isfinite(gyro) && std::isfinite(heading) && agree(heading - gyro, -imu);
  // Steering comes no earlier before the path than the nose does, but with drivers who swing it; a
  // car slows as it is braked.
  const double steering = lag(kSteer, s.x[kSteer], path.curvature, 0.005, false),
               nose = std::isfinite(gyro) ? std::min(gyro, 0.0) : 0.0,
               brakes = brakes_late_by(s, rate);
  // Wheels that slip speed up by a tenth of a second before the car: they tell the side alone.
  const double wheels = lag(kWheelFront, s.dx[kWheelFront], rate, 0.5, false);
  const bool of_speed = !(std::abs(vx) < kAgree_s);
  const double bus = of_speed                                              ? vx
                     : (brakes > 0 ? wheels > -kAgree_s : wheels < brakes) ? brakes
                                                                           : kNaN;
  const bool with_bus = bus > 0 ? steering > std::max(0.6 * bus, bus - kAgree_s + nose) ||
                                      (of_speed && brakes > std::max(0.6 * bus, bus - 0.05))
                                : bus < -kEarly_s && steering < 0.6 * bus + nose;
  // Of all these a heading is told best from what turns it.
  if (heading_with_path) imu = gyro - heading;
  std::vector<Channel> late;
  double delay_s = 0.0;
  if (std::abs(imu) > kLeast_s && (agree(imu, vx) || (imu < 0 && std::abs(vx) < kAgree_s))) {
    late = {kX, kY};
    if (!agree(imu, vx)) late.push_back(kVx);
    if (heading_with_path) {
      late.push_back(kYaw);
      if (agree(lag(kVy, s.x[kVy], path.slip_mps, 0.1, false), 0.0)) late.push_back(kVy);
    }
    delay_s = -imu;
  } else if (imu > kLeast_s && std::abs(vx) < kAgree_s && std::isfinite(ax) && std::isfinite(ay) &&
             heading_with_path) {
    // Two of the three may be filtered alike; all of them have one clock.
    late = {kAx, kAy, kAz, kYawRate};
    delay_s = imu;
  } else if (std::abs(bus) > kLeast_s && std::abs(imu) < kAgree_s &&
             (s.commanded[kSteer] ? of_speed && std::abs(wheels - vx) < kWheels_s : with_bus)) {
    late = {kVx,           kWheelFront,
            kWheelRear,    kWheelRearDifference,
            kSteer,        kThrottle,
            kBrakeFront,   kBrakeRear,
            kEngine,       kGear,
            kLoadFront,    kLoadRear,
            kSteerCommand, kThrottleCommand,
            kBrakeCommand};
    if (!of_speed) late.erase(late.begin());
    delay_s = bus;
  } else if (std::abs(vx) > kEarly_s && std::abs(imu) < kAgree_s) {
    late = {kVx};
    delay_s = vx;
  } else {
    return std::nullopt;
  }
  return LateColumns{columns_of(s, late), delay_s};
}

}  // namespace explain
