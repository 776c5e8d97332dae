#include "brakes_rows.h"

#include <algorithm>
#include <cmath>

#include "vehicle/laws/brake_pads.h"
#include "vehicle/laws/engine.h"

namespace identify {
namespace {

using vehicle::kWheels;
using P = vehicle::Parameter;
using vehicle::Term;
constexpr double kEngineDragShare = 0.2;  ///< standard deviation of it

/// Braking and shifting down go together: where the gear changed, that of the middle counts.
int gear_while_braking(const vehicle::Car<double>& car, const DriveWindow& w) {
  if (const auto gear = gear_of(car, w)) return *gear;
  return std::isfinite(w.middle_gear) ? static_cast<int>(std::lround(w.middle_gear)) : 0;
}

/// Friction of the pads by the vehicle file; without a recorded temperature, that of the map's
/// middle.
double friction(const vehicle::Car<double>& car, const DriveWindow& w, std::size_t wheel) {
  const std::size_t a = vehicle::axle_of(wheel);
  const vehicle::Map2& map = car.files->pad_friction;
  const double constant = car.parameters.axle(a, P::front_brake_friction);
  const double amount = car.terms[Term::brake_friction_temperature];
  if (map.empty() || amount == 0.0) return constant;
  const double kelvin =
      std::isfinite(w.disc_k[wheel]) ? w.disc_k[wheel] : 0.5 * (map.y.front() + map.y.back());
  return vehicle::laws::pad_friction(constant, amount, map, std::max(0.0, w.brake_pa[wheel]),
                                     kelvin);
}

}  // namespace

bool brakes_count(const vehicle::Car<double>& car, const DriveWindow& w) {
  double most = 0.0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    if (!std::isfinite(w.brake_pa[i])) return false;
    most = std::max(most, w.brake_pa[i]);
    const double turns = w.wheel_radps[i] * car.static_radius_m[vehicle::axle_of(i)];
    if (turns < 0.85 * w.vx_mps) return false;  // NaN: not recorded, not known to lock
  }
  return most > kBraking_pa && std::abs(left_mps2(w)) <= 6.0 && !(w.throttle > 0.05) &&
         (w.gear_recorded || gear_of(car, w).has_value());
}

double stated_force(const vehicle::Car<double>& car, const DriveWindow& w, std::size_t axle,
                    double mass_kg) {
  double torque = 0.0;
  for (std::size_t i = 2 * axle; i < 2 * axle + 2; ++i)
    torque += vehicle::laws::brake_torque(friction(car, w, i), std::max(0.0, w.brake_pa[i]),
                                          car.parameters.axle(axle, P::front_brake_area_m2),
                                          car.parameters.axle(axle, P::front_brake_radius_m));
  return torque / force_arm(car, w, axle, mass_kg);
}

std::vector<Granted> brakes_moved(const Along& along) {
  return along.moved({{&Granted::mass_kg, along.mass_sd_kg},
                      {&Granted::rolling, kRollingShare},
                      {&Granted::engine, kEngineDragShare},
                      {&Granted::drag, share_sd(along.prior, P::aero_drag_area_m2)},
                      {&Granted::offset_mps2, kOffset_mps2}});
}

double braking_force(const vehicle::Car<double>& car, const DriveWindow& w, bool by_speed,
                     const Granted& g) {
  const int gear = gear_while_braking(car, w);
  const AlongForces f = along_forces(car, w, g.mass_kg, gear, by_speed);
  double engine = 0.0;
  if (gear > 0) {
    const Gearing geared = gearing(car, w, gear, g.mass_kg, false);
    engine = std::min(0.0, vehicle::laws::map_torque(car.parameters[P::engine_torque],
                                                     car.files->engine_torque_nm,
                                                     geared.engine_radps, 0.0)) *
             geared.per_torque_1pm;
  }
  return g.engine * engine - f.inertia_n - g.mass_kg * g.offset_mps2 - g.rolling * f.rolling_n -
         g.drag * car.parameters[P::aero_drag_area_m2] * f.drag_m2_n;
}

}  // namespace identify
