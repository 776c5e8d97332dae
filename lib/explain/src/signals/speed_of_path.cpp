#include "speed_of_path.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "changes_in_time.h"
#include "not_known.h"
#include "vehicle/error.h"

namespace explain {

void refuse_another_unit(const Signals& s) {
  double vv = 0, vp = 0;
  std::vector<double> speed = s.x[kVx], rolling(s.n, kNaN);  // where the car stands, places jitter
  for (std::size_t i = 0; i < s.n; ++i) {
    if (s.present[kVy] && std::isfinite(s.x[kVy][i])) speed[i] = std::hypot(speed[i], s.x[kVy][i]);
    const double path = std::hypot(s.dx[kX][i], s.dx[kY][i]);
    if (path > kMayStand_mps) rolling[i] = path;
    if (std::isfinite(path + s.x[kVx][i]))
      vv += s.x[kVx][i] * s.x[kVx][i], vp += s.x[kVx][i] * path;
  }
  if (const auto change = ratio_changes(speed, rolling, kSpeedChanges))
    throw vehicle::Error(fmt::format(
        "{}: '{}' is {:.2f} times as fast as the path until about {:.0f} s, and {:.2f} times after "
        "it: one unit throughout is wanted; mend the column, or cut the log there",
        s.name, s.column[kVx], change->before, change->time_s, change->after));
  const double ratio = vv > 0 ? vp / vv : 0.0;
  if (ratio < 0.7 || ratio > 1.4)
    throw vehicle::Error(fmt::format(
        "{}: the path is {:.3f} times as fast as '{}': another unit, or not the forward speed",
        s.name, ratio, s.column[kVx]));
  // Over a second, in which jitter of places adds nothing.
  constexpr std::size_t kSecond = static_cast<std::size_t>(1.0 / Signals::kStep_s);
  constexpr double kWheels = 0.06;  // and what tachometers flatter by
  constexpr double kStraight_rad = 0.3, kTurn_rad = 2 * std::numbers::pi;  // a chord is shorter
  double way_m = 0, chords_m = 0;
  const auto course = [&](std::size_t i) { return std::atan2(s.dx[kY][i], s.dx[kX][i]); };
  for (std::size_t i = 0; i + kSecond < s.n; i += kSecond) {
    const double chord_m =
        std::hypot(s.x[kX][i + kSecond] - s.x[kX][i], s.x[kY][i + kSecond] - s.x[kY][i]);
    const double mean_mps = 0.5 * (speed[i] + speed[i + kSecond]);
    const double turned_rad = std::remainder(course(i + kSecond) - course(i), kTurn_rad);
    if (std::isfinite(chord_m) && mean_mps > kMayStand_mps && std::abs(turned_rad) < kStraight_rad)
      way_m += mean_mps, chords_m += chord_m;
  }
  if (way_m > 0 && std::abs(chords_m / way_m - 1) > kWheels)
    throw vehicle::Error(fmt::format(
        "{}: the path is {:.3f} times as fast as '{}', and no sensor of speed is off by so much: "
        "give that column the scale {:.4g} in the mapping, or the places one",
        s.name, chords_m / way_m, s.column[kVx], chords_m / way_m));
}

double speed_over_wheels(const Signals& log, Channel wheels) {
  double speed = 0.0, rolled = 0.0;
  for (std::size_t i = 0; i < log.n; ++i)
    if (log.x[kVx][i] > Signals::kRolls_mps && std::isfinite(log.x[wheels][i]))
      speed += log.x[kVx][i], rolled += log.x[wheels][i];
  return rolled > 0 ? speed / rolled : 0.0;
}

std::optional<Channel> wheels_of_speed(const Signals& log) {
  constexpr double kSame = 0.002;
  if (!log.wheels_in_mps) return std::nullopt;
  for (const Channel wheels : {kWheelRear, kWheelFront})
    if (log.present[wheels] && std::abs(speed_over_wheels(log, wheels) - 1) < kSame) return wheels;
  return std::nullopt;
}

}  // namespace explain
