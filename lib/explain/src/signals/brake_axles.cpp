#include "brake_axles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/statistics.h"
#include "not_known.h"

namespace explain {
namespace {

using P = vehicle::Parameter;
constexpr double kSlips_mps = 8.0, kBraked_pa = 2e5;

/// What slip the wheels of an axle gain per pressure, and the share of it that noise may be.
struct Braked {
  double slip_1ppa = kNaN, deviation = kNaN;
};

Braked braked(const Signals& s, Channel wheel, Channel brake) {
  std::vector<double> radius_m;
  for (std::size_t i = 0; i < s.n; ++i)
    if (s.x[kVx][i] > kSlips_mps && s.x[wheel][i] > 0 && s.x[brake][i] < kBraked_pa)
      radius_m.push_back(s.x[kVx][i] / s.x[wheel][i]);
  if (radius_m.size() < 200) return {};
  const double rolling_m = base::median(std::move(radius_m));
  double n = 0, sp = 0, sl = 0, pp = 0, pl = 0, ll = 0;
  for (std::size_t i = 0; i < s.n; ++i) {
    const double p = s.x[brake][i], slip = 1 - rolling_m * s.x[wheel][i] / s.x[kVx][i];
    if (!(s.x[kVx][i] > kSlips_mps) || !(p > kBraked_pa) || !(std::abs(slip) < 0.3)) continue;
    n += 1, sp += p, sl += slip, pp += p * p, pl += p * slip, ll += slip * slip;
  }
  if (n < 40) return {};
  // What drags beside the brakes is there at any pressure. Smoothed, steps say the same for half a
  // second.
  constexpr double kAlike = 10.0;
  const double vp = pp - sp * sp / n, slope = (pl - sp * sl / n) / vp,
               left = std::max(0.0, ll - sl * sl / n - slope * slope * vp);
  return {slope, std::sqrt(left / n * kAlike / vp) / std::abs(slope)};
}

/// The logarithm of the pressure in front over that behind, where both press.
double pressures_apart(const Signals& s) {
  std::vector<double> apart;
  for (std::size_t i = 0; i < s.n; ++i)
    if (s.x[kBrakeFront][i] > kBraked_pa && s.x[kBrakeRear][i] > kBraked_pa)
      apart.push_back(std::log(s.x[kBrakeFront][i] / s.x[kBrakeRear][i]));
  return base::median_or(0.0, std::move(apart));
}

/// Slip per pressure in front over that behind, of the stated car: torques by loads, which braking
/// moves forwards.
double stated_ratio(const Signals& s, const vehicle::Vehicle& car) {
  const auto& p = car.parameters;
  double slowing = 0, square = 0, count = 0;
  for (std::size_t i = 0; i < s.n; ++i)
    if (s.x[kVx][i] > kSlips_mps && s.x[kBrakeFront][i] > kBraked_pa && std::isfinite(s.dx[kVx][i]))
      slowing -= s.dx[kVx][i], square += s.x[kVx][i] * s.x[kVx][i], count += 1;
  const double mass = p[P::chassis_mass_kg], base_m = p[P::chassis_wheelbase_m],
               behind_m = p[P::chassis_cog_behind_front_m],
               moved_n = mass * slowing / count * p[P::chassis_cog_height_m] / base_m,
               pressure = 0.5 * p[P::aero_density_kgpm3] * square / count,
               weight_n = mass * p[P::environment_gravity_mps2];
  const double front_n = weight_n * (base_m - behind_m) / base_m + moved_n +
                         pressure * p[P::front_lift_area_m2],
               rear_n = weight_n * behind_m / base_m - moved_n + pressure * p[P::rear_lift_area_m2];
  const auto torque = [&](P area, P radius, P friction) {
    return p[area] * p[radius] * p[friction];
  };
  return torque(P::front_brake_area_m2, P::front_brake_radius_m, P::front_brake_friction) /
         torque(P::rear_brake_area_m2, P::rear_brake_radius_m, P::rear_brake_friction) * rear_n /
         front_n;
}

}  // namespace

void leave_out_exchanged_brakes(Signals& s, const vehicle::Vehicle& car) {
  for (const Channel c : {kWheelFront, kWheelRear, kBrakeFront, kBrakeRear})
    if (!s.present[c]) return;
  if (s.column[kBrakeFront] == s.column[kBrakeRear]) return;
  constexpr double kFifth = 0.2;
  const Braked front = braked(s, kWheelFront, kBrakeFront),
               rear = braked(s, kWheelRear, kBrakeRear);
  if (!(front.slip_1ppa > 0) || !(rear.slip_1ppa > 0)) return;
  // Exchanged, each pressure is the other's: the ratio of the slips is off by their ratio twice.
  const double apart = pressures_apart(s),
               off = std::log(front.slip_1ppa / rear.slip_1ppa / stated_ratio(s, car)),
               sure = 2 * std::hypot(front.deviation, rear.deviation);
  if (!(std::abs(apart) > kFifth) || !(-off * std::copysign(1.0, apart) - sure > std::abs(apart)))
    return;
  s.broken = true;
  s.remarks.push_back(
      fmt::format("{}: '{}' press {:.2f} times as much as '{}', and under braking the wheels slip "
                  "as if it were the other way round: front and rear are exchanged, or the vehicle "
                  "file has other brakes: not used; correct it in the mapping",
                  s.name, s.column[kBrakeFront], std::exp(apart), s.column[kBrakeRear]));
  for (const Channel c : {kBrakeFront, kBrakeRear, kBrakeFrontApart, kBrakeRearApart})
    s.present[c] = false;
}

}  // namespace explain
