// What drives: engine, turbocharger, clutch, gears, differential, fuel.
#pragma once

#include <cmath>

#include "vehicle/dynamics/evaluation.h"
#include "vehicle/laws/boost.h"
#include "vehicle/laws/driveline.h"
#include "vehicle/laws/engine.h"
#include "vehicle/laws/fuel.h"

namespace vehicle::dynamics {

inline laws::TurboMaps turbo_maps(const CarFiles& files) {
  return {files.compressor_kgps, files.compressor_efficiency, files.turbine_flow,
          files.turbine_efficiency};
}

/// Torque of the full turbocharged engine and the rates of its air path.
template <class T, TermSet Built>
T breathe(Evaluation<T, Built>& e, const T& throttle, const T& fuelled) {
  const State<T>& s = e.s;
  Detail<T>& detail = e.detail;
  const laws::TurboParameters<T> path = laws::turbo_parameters(e.p);
  detail.turbo = laws::turbocharged<T>(
      path,
      {e.amount(Term::compressor_map), e.amount(Term::wastegate), e.amount(Term::overrun_valve),
       e.amount(Term::intercooler), e.amount(Term::turbine_map)},
      {s[kManifold], s[kCharge], s[kExhaust], s[kTurbo]}, s[kEngine], throttle, fuelled,
      turbo_maps(e.files));
  detail.boost = (s[kCharge] - path.air_pa) / path.wastegate_pa;
  e.out[kManifold] = detail.turbo.manifold_paps;
  e.out[kCharge] = detail.turbo.charge_paps;
  e.out[kExhaust] = detail.turbo.exhaust_paps;
  e.out[kTurbo] = detail.turbo.shaft_radps2;
  detail.power.turbo = detail.turbo.shaft_nm * s[kTurbo];
  return e.p[Parameter::engine_torque] * detail.turbo.engine_nm;
}

/// Torque of the engine map with limiter and first-order boost.
template <class T, TermSet Built>
T fire(Evaluation<T, Built>& e, const T& throttle, const T& fuelled) {
  using P = Parameter;
  const T& engine_speed = e.s[kEngine];
  T torque = laws::limited_torque(
      laws::map_torque(e.p[P::engine_torque], e.files.engine_torque_nm, engine_speed, throttle),
      fuelled);
  if (e.active(Term::turbo_lag)) {
    const T& boost = e.s[kBoost];
    e.out[kBoost] = laws::boost_rate(laws::boost_parameters(e.p), boost, engine_speed, throttle);
    torque = laws::boosted_torque(torque, T(e.amplitude(Term::turbo_lag) * e.p[P::turbo_share]),
                                  T(throttle - boost));
  }
  return torque;
}

/// The engine's torque on its own shaft.
template <class T, TermSet Built>
void run_engine(Evaluation<T, Built>& e) {
  using P = Parameter;
  const T& engine_speed = e.s[kEngine];
  Detail<T>& detail = e.detail;
  const T throttle = laws::clip(e.in.throttle, 0.0, 1.0);
  const T fuelled = laws::fuelled_share(e.p[P::engine_limit_radps], engine_speed);
  detail.boost = e.s[kBoost];
  e.out[kBoost] = e.out[kManifold] = e.out[kCharge] = e.out[kExhaust] = e.out[kTurbo] = T(0);
  e.map_torque =
      e.files.turbo == Turbo::kFull ? breathe(e, throttle, fuelled) : fire(e, throttle, fuelled);
  detail.engine_nm = e.map_torque + laws::idle_torque(e.p, engine_speed);
  const auto matches = is_gear(e.in.next_gear) && !exactly_zero(e.p[P::gearbox_rev_match]) &&
                       e.p[P::gearbox_shift_s] > T(0);
  if (any(matches)) {
    const T ratio = overall_ratio(e.p, e.in.next_gear);
    const auto matched = [&] {
      return laws::rev_match_torque(e.p, detail.engine_nm, engine_speed,
                                    T(ratio * 0.5 * (e.spin[2] + e.spin[3])));
    };
    detail.engine_nm = choose(matches && ratio != T(0), matched, [&] { return detail.engine_nm; });
  }
  e.engine_torque += detail.engine_nm;
  detail.power.engine += detail.engine_nm * engine_speed;
}

/// Clutch and gears: the torque into the differential.
template <class T, TermSet Built>
T engage_clutch(Evaluation<T, Built>& e) {
  using P = Parameter;
  const T ratio = overall_ratio(e.p, e.in.gear);
  const auto engaged = ratio != T(0);
  if (!any(engaged)) return T(0);
  const T& engine_speed = e.s[kEngine];
  Detail<T>& detail = e.detail;
  T capacity = laws::clutch_capacity(e.p, e.amount(Term::centrifugal_clutch), engine_speed);
  if (!is_exactly_zero(e.in.clutch)) capacity *= 1.0 - laws::clip(e.in.clutch, 0.0, 1.0);
  const T slip = engine_speed - ratio * 0.5 * (e.spin[2] + e.spin[3]);
  const laws::SlipFriction<T> clutch =
      laws::slip_friction(capacity, slip, e.p[P::clutch_stick_radps]);
  const auto set = [&](T& to, const T& value) { to = select(engaged, value, to); };
  set(detail.clutch_slip_radps, slip);
  set(detail.clutch_nm, clutch.torque_nm);
  set(detail.clutch_stiffness_nms, clutch.stiffness_nms);
  set(detail.gear_ratio, ratio);
  set(detail.drive_efficiency, laws::gear_efficiency(e.p[P::gearbox_efficiency], detail.clutch_nm));
  const T driven = detail.clutch_nm * ratio * detail.drive_efficiency;
  set(e.engine_torque, T(e.engine_torque - detail.clutch_nm));
  set(detail.power.clutch, T(-detail.clutch_nm * slip));
  set(detail.power.driveline, T(detail.power.driveline - (detail.clutch_nm * engine_speed -
                                                          driven * 0.5 * (e.spin[2] + e.spin[3]))));
  return select(engaged, driven, T(0));
}

/// Clutch, gears and differential: the torques on the driven wheels.
template <class T, TermSet Built>
void turn_driveline(Evaluation<T, Built>& e) {
  using P = Parameter;
  Detail<T>& detail = e.detail;
  const T driven = engage_clutch(e);
  const T difference = e.spin[2] - e.spin[3];
  detail.differential_slip_radps = difference;
  if (e.active(Term::limited_slip)) {
    const T capacity = laws::limited_slip_torque(e.p, e.amplitude(Term::limited_slip), driven);
    const laws::SlipFriction<T> f =
        laws::slip_friction(capacity, difference, e.p[P::differential_stick_radps]);
    detail.limited_slip_nm = capacity;
    detail.limited_slip_grip = f.grip;
    detail.differential_nm += f.torque_nm;
    detail.differential_stiffness_nms += f.stiffness_nms;
  }
  if (e.active(Term::locked_differential)) {
    const T lock = e.amplitude(Term::locked_differential) * e.p[P::differential_lock_nms];
    detail.differential_nm += lock * difference;
    detail.differential_stiffness_nms += lock;
  }
  detail.power.driveline -= detail.differential_nm * difference;
  detail.wheel[2].drive_nm = 0.5 * driven - detail.differential_nm;
  detail.wheel[3].drive_nm = 0.5 * driven + detail.differential_nm;
}

/// Fuel that burns, and the power that leaves with its mass.
template <class T, TermSet Built>
void burn_fuel(Evaluation<T, Built>& e) {
  e.out[kFuel] = T(0);
  const auto fuelled = e.s[kFuel] > T(0);
  if (!e.active(Term::fuel_burn) || !any(fuelled)) return;
  const T burn = e.files.turbo == Turbo::kFull ? e.detail.turbo.fuel_kgps
                                               : laws::fuel_kgps(e.p, e.map_torque, e.s[kEngine]);
  e.out[kFuel] = select(fuelled, T(-e.amplitude(Term::fuel_burn) * burn), T(0));
  const Vec3<T> tank_v = e.V + cross(e.omega, e.car.tank_m);
  const T per_kg = 0.5 * dot(tank_v, tank_v) + e.p[Parameter::environment_gravity_mps2] *
                                                   (e.position.z + e.R.apply(e.car.tank_m).z);
  e.detail.power.fuel = select(fuelled, T(e.out[kFuel] * per_kg), T(0));
}

}  // namespace vehicle::dynamics
