// The air path of a turbocharged engine: a mean-value model with four states.
//
// Volumes at constant temperature, flows through throttle, valves and cylinders, torque from the
// air: L. Guzzella and C. H. Onder, Introduction to Modeling and Control of Internal Combustion
// Engine Systems, 2nd edition 2010, chapter 2, with their approximation of the isentropic nozzle.
// Turbine flow: Stodola's ellipse; turbine efficiency: a parabola over the blade speed ratio, as
// there. Compressor: the head falls from that of no flow with the square of the flow (ideal head
// less a friction loss), efficiency a parabola over the flow coefficient. Where a map is given,
// flow and efficiency are the map's; maps of turbines are over reduced speed and expansion ratio,
// flows reduced too: N. Watson and M. S. Janota, Turbocharging the Internal Combustion Engine,
// 1982.
#pragma once

#include <cmath>
#include <cstddef>

#include "vehicle/laws/soft_root.h"
#include "vehicle/map.h"
#include "vehicle/maths.h"
#include "vehicle/parameters.h"

namespace vehicle::laws {

inline constexpr double kGas = 287.0;         ///< J/(kg K), air and exhaust gas
inline constexpr double kAirHeat = 1004.5;    ///< J/(kg K), of air at constant pressure
inline constexpr double kExhaustHeat = 1150;  ///< J/(kg K), of exhaust gas

/// A flow, kg/s, and its derivatives after the pressures before and behind, kg/(s Pa).
template <class T>
struct Flow {
  T kgps = T(0), per_before = T(0), per_behind = T(0);

  friend Flow select(const Flag<T>& which, const Flow& a, const Flow& b) {
    return {vehicle::select(which, a.kgps, b.kgps),
            vehicle::select(which, a.per_before, b.per_before),
            vehicle::select(which, a.per_behind, b.per_behind)};
  }
};

/// Through an opening of effective area `area_m2`: p / sqrt(R T) area psi, psi = sqrt(2 r (1 - r))
/// for pressure ratios r above 1/2, sqrt(1/2) below (Guzzella and Onder; within 4 % of the
/// isentropic nozzle of air). Above r = 0.98 the root is regularised. Backwards where the pressure
/// behind is the greater.
template <class T>
Flow<T> nozzle(const T& area_m2, const T& before_pa, const T& behind_pa, const T& before_k,
               const T& behind_k) {
  using std::sqrt;
  const auto back = behind_pa > before_pa;
  const T high_pa = select(back, behind_pa, before_pa), low_pa = select(back, before_pa, behind_pa);
  const T scale = area_m2 / sqrt(T(kGas * select(back, behind_k, before_k)));
  const T ratio = low_pa / high_pa;
  const auto choked = [&] {
    const double psi = std::sqrt(0.5);
    return Flow<T>{scale * high_pa * psi, scale * psi, T(0)};
  };
  const auto open = [&] {
    const Sloped<T> psi = soft_root(T(2.0 * ratio * (1.0 - ratio)), 2.0 * 0.98 * 0.02);
    const T slope = psi.slope * (2.0 - 4.0 * ratio);
    return Flow<T>{scale * high_pa * psi.value, scale * (psi.value - ratio * slope), scale * slope};
  };
  const Flow<T> out = choose(ratio < T(0.5), choked, open);
  return {select(back, T(-out.kgps), out.kgps), select(back, T(-out.per_behind), out.per_before),
          select(back, T(-out.per_before), out.per_behind)};
}

/// What the air path is made of; names and units as in parameters.def.
template <class T>
struct TurboParameters {
  T displacement_m3, compression, filling, indicated, coolant_share, air_fuel, friction_pa,
      friction_pas;                                        // engine
  T manifold_m3, charge_m3, throttle_m2, leak_m2, cooler;  // intake
  T overrun_m2, overrun_pa, overrun_range_pa;
  T compressor_m, head, flow, compressor_efficiency, best_flow, narrowness;
  T turbine_m, turbine_m2, turbine_efficiency, blade_ratio, exhaust_m3;
  T wastegate_m2, wastegate_pa, wastegate_range_pa;
  T inertia_kgm2, bearing_nms;
  T fuel_jpkg, air_pa, air_k;
};

/// Pressure of the air around, Pa, by the stated density and temperature.
template <class T>
T air_pressure(const Parameters<T>& p) {
  return p[Parameter::aero_density_kgpm3] * kGas * p[Parameter::environment_temperature_k];
}

/// The air path's parameters as its law wants them.
template <class T>
TurboParameters<T> turbo_parameters(const Parameters<T>& p) {
  using P = Parameter;
  return {p[P::engine_displacement_m3],
          p[P::engine_compression],
          p[P::engine_filling],
          p[P::engine_indicated],
          p[P::engine_coolant_share],
          p[P::engine_air_fuel],
          p[P::engine_friction_pa],
          p[P::engine_friction_pas],
          p[P::intake_manifold_m3],
          p[P::intake_charge_m3],
          p[P::intake_throttle_m2],
          p[P::intake_leak_m2],
          p[P::intake_cooler],
          p[P::intake_overrun_m2],
          p[P::intake_overrun_pa],
          p[P::intake_overrun_range_pa],
          p[P::compressor_diameter_m],
          p[P::compressor_head],
          p[P::compressor_flow],
          p[P::compressor_efficiency],
          p[P::compressor_best_flow],
          p[P::compressor_narrowness],
          p[P::turbine_diameter_m],
          p[P::turbine_area_m2],
          p[P::turbine_efficiency],
          p[P::turbine_blade_ratio],
          p[P::turbine_exhaust_m3],
          p[P::turbine_wastegate_m2],
          p[P::turbine_wastegate_pa],
          p[P::turbine_wastegate_range_pa],
          p[P::turbo_inertia_kgm2],
          p[P::turbo_bearing_nms],
          p[P::fuel_energy_jpkg],
          air_pressure(p),
          p[P::environment_temperature_k]};
}

/// How much acts of what can be switched, 0 to 1.
template <class T>
struct TurboAmounts {
  T map, wastegate, overrun, intercooler, turbine_map;
};

/// The maps of a turbocharger; an empty one leaves the closed form.
struct TurboMaps {
  const Map2 &compressor_kgps, &compressor_efficiency, &turbine_flow, &turbine_efficiency;
};

template <class T>
struct TurboState {
  T manifold_pa, charge_pa, exhaust_pa, shaft_radps;
};

/// Flows, powers and rates. `drift` is the Jacobian of the pressures' rates after the pressures,
/// 1/s, for a step that treats them implicitly: manifold and charge, exhaust apart; the slope of
/// the compressor is that of its closed form also where a map acts.
template <class T>
struct TurboRates {
  T manifold_paps = T(0), charge_paps = T(0), exhaust_paps = T(0), shaft_radps2 = T(0);
  T engine_nm = T(0);  ///< indicated less friction and gas exchange
  T fuel_kgps = T(0);
  T shaft_nm = T(0);  ///< turbine less compressor less bearings
  T compressor_w = T(0), turbine_w = T(0), bearing_w = T(0);  ///< on the shaft, all positive
  T compressor_kgps = T(0), throttle_kgps = T(0), overrun_kgps = T(0), cylinder_kgps = T(0),
    turbine_kgps = T(0), wastegate_kgps = T(0);
  T charge_k = T(0), exhaust_k = T(0);
  struct {
    T manifold = T(0), manifold_charge = T(0), charge_manifold = T(0), charge = T(0),
      exhaust = T(0);
  } drift;
};

/// Compressor: flow and efficiency at a pressure behind it. Closed form: the isentropic head over
/// half the square of the tip speed is head (1 - (phi / flow)^2), phi the flow over density, wheel
/// area and tip speed; backwards beyond the head of no flow (no surge cycle is modelled). Best
/// efficiency at phi = best_flow, less narrowness times the square of the relative distance, not
/// below 0.35 of the best. Maps: over shaft speed, rad/s, and pressure ratio.
template <class T>
struct Compressor {
  T kgps, per_pa, efficiency, isentropic_jpkg;
};
template <class T>
Compressor<T> compressor(const TurboParameters<T>& p, const T& shaft_radps, const T& behind_pa,
                         const TurboMaps& maps, const T& mapped) {
  using maths::pow;
  const Map2 &flow_map = maps.compressor_kgps, &efficiency_map = maps.compressor_efficiency;
  constexpr double kExponent = kGas / kAirHeat;
  const T ratio = behind_pa / p.air_pa;
  const T power = pow(ratio, kExponent);
  Compressor<T> out;
  out.isentropic_jpkg = kAirHeat * p.air_k * (power - 1.0);
  const T tip_mps = 0.5 * p.compressor_m * shaft_radps;
  const T area_density =
      p.air_pa / (kGas * p.air_k) * 0.7853981633974483 * p.compressor_m * p.compressor_m;  // kg/m
  const Sloped<T> root =
      soft_root(T(tip_mps * tip_mps - 2.0 * out.isentropic_jpkg / p.head), 3600.0);
  out.kgps = area_density * p.flow * root.value;
  out.per_pa = -area_density * p.flow * root.slope * 2.0 * kAirHeat * p.air_k * kExponent * power /
               (behind_pa * p.head);
  const T wheel_mps = select(tip_mps > T(20), tip_mps, T(20));
  T away = out.kgps / (area_density * wheel_mps * p.best_flow) - 1.0;
  away = select(away > T(2), T(2), away);
  away = select(away < T(-1), T(-1), away);
  T share = 1.0 - p.narrowness * away * away;
  share = select(share < T(0.35), T(0.35), share);
  out.efficiency = p.compressor_efficiency * share;
  if (!is_exactly_zero(mapped)) {
    if (!flow_map.empty()) out.kgps += mapped * (evaluate(flow_map, shaft_radps, ratio) - out.kgps);
    if (!efficiency_map.empty())
      out.efficiency += mapped * (evaluate(efficiency_map, shaft_radps, ratio) - out.efficiency);
  }
  return out;
}

/// True where a compressor gives less than its surge line asks at a pressure ratio. What happens
/// there is not modelled as a cycle: the flow just falls or turns.
inline bool surges(const Map1& least_kgps, double kgps, double pressure_ratio) {
  return !least_kgps.empty() && kgps < evaluate(least_kgps, pressure_ratio);
}

/// Turbine and wastegate: flows, the turbine's torque, and how fast both flows grow with the
/// pressure before them.
template <class T>
struct Turbine {
  T kgps, wastegate_kgps, torque_nm, per_pa;
};

/// What the maps leave of the closed form: the turbine's flow times the root of the temperature
/// over the pressure before it is the map's, its power is the isentropic one times the map's
/// efficiency. Below 500 rad/s the torque is that of its power at 500.
template <class T>
void map_turbine(const TurboMaps& maps, const T& mapped, const T& expansion_ratio,
                 const T& exhaust_pa, const T& exhaust_k, const T& shaft_radps, const T& air_pa,
                 Turbine<T>& out) {
  using maths::pow;
  using std::sqrt;
  const T root_k = sqrt(exhaust_k), reduced_radps = shaft_radps / root_k;
  if (!maps.turbine_flow.empty()) {
    constexpr double kFurther = 1e-3, kPerMega = 1e-6;
    const T reduced = kPerMega * evaluate(maps.turbine_flow, reduced_radps, expansion_ratio);
    const T further =
        kPerMega * evaluate(maps.turbine_flow, reduced_radps, T(expansion_ratio + kFurther));
    const T kgps = reduced * exhaust_pa / root_k;
    const T per_pa = (reduced + (further - reduced) / kFurther * exhaust_pa / air_pa) / root_k;
    out.torque_nm =
        select(out.kgps > T(0), T(out.torque_nm * (1.0 + mapped * (kgps / out.kgps - 1.0))),
               out.torque_nm);
    out.kgps += mapped * (kgps - out.kgps);
    out.per_pa += mapped * (select(per_pa > T(0), per_pa, T(0)) - out.per_pa);
  }
  if (!maps.turbine_efficiency.empty()) {
    const T efficiency = evaluate(maps.turbine_efficiency, reduced_radps, expansion_ratio);
    const T expansion_jpkg =
        kExhaustHeat * exhaust_k * (1.0 - pow(expansion_ratio, -kGas / kExhaustHeat));
    const T per_radps = select(shaft_radps > T(500), shaft_radps, T(500));
    const T torque_nm =
        select(expansion_ratio > T(1), T(out.kgps * efficiency * expansion_jpkg / per_radps), T(0));
    out.torque_nm += mapped * (torque_nm - out.torque_nm);
  }
}

template <class T>
Turbine<T> turbine(const TurboParameters<T>& p, const T& wastegate, const T& charge_pa,
                   const T& exhaust_pa, const T& exhaust_k, const T& shaft_radps,
                   const TurboMaps& maps, const T& mapped) {
  using maths::pow;
  using std::sqrt;
  Turbine<T> out{T(0), T(0), T(0), T(0)};
  const T ratio = p.air_pa / exhaust_pa;
  const T scale = p.turbine_m2 / sqrt(kGas * exhaust_k);
  const Sloped<T> ellipse = soft_root(T(1.0 - ratio * ratio), 0.04);
  out.kgps = scale * exhaust_pa * ellipse.value;
  out.per_pa = scale * (ellipse.value + 2.0 * ratio * ratio * ellipse.slope);
  const auto driven = [&] {
    const T expansion_jpkg = kExhaustHeat * exhaust_k * (1.0 - pow(ratio, kGas / kExhaustHeat));
    const T jet_mps = soft_root(T(2.0 * expansion_jpkg), 2500.0).value;
    const T radius_m = 0.5 * p.turbine_m;
    return T(
        out.kgps * p.turbine_efficiency * radius_m *
        (jet_mps / p.blade_ratio - radius_m * shaft_radps / (2.0 * p.blade_ratio * p.blade_ratio)));
  };
  out.torque_nm = choose(out.kgps > T(0), driven, [] { return T(0); });
  if (!is_exactly_zero(mapped))
    map_turbine(maps, mapped, T(exhaust_pa / p.air_pa), exhaust_pa, exhaust_k, shaft_radps,
                p.air_pa, out);
  if (!is_exactly_zero(wastegate)) {
    const Sloped<T> open =
        soft_step(T((charge_pa - p.air_pa - p.wastegate_pa) / p.wastegate_range_pa));
    const Flow<T> past = nozzle(T(wastegate * open.value * p.wastegate_m2), exhaust_pa, p.air_pa,
                                exhaust_k, p.air_k);
    out.wastegate_kgps = past.kgps;
    out.per_pa += past.per_before;
  }
  return out;
}

/// The whole air path. `throttle` from 0 to 1 is the angle of the plate over a right angle;
/// `fuelled` the share of the cylinders' air that gets fuel (the limiter cuts). Pressures below
/// 1 kPa count as that.
template <class T>
TurboRates<T> turbocharged(const TurboParameters<T>& p, const TurboAmounts<T>& amount,
                           const TurboState<T>& s, const T& engine_radps, const T& throttle,
                           const T& fuelled, const TurboMaps& maps) {
  using maths::cos;
  using maths::pow;
  constexpr double kPi = 3.141592653589793;
  const auto at_least = [](const T& x, double least) { return select(x > T(least), x, T(least)); };
  const T manifold_pa = at_least(s.manifold_pa, 1e3), charge_pa = at_least(s.charge_pa, 1e3);
  const T exhaust_pa = at_least(s.exhaust_pa, 1e3);
  const T shaft = at_least(s.shaft_radps, 0.0), engine = at_least(engine_radps, 0.0);
  TurboRates<T> out;

  // Compressor and intercooler.
  const Compressor<T> c = compressor(p, shaft, charge_pa, maps, amount.map);
  out.compressor_kgps = c.kgps;
  const T heated_k = at_least(T(c.isentropic_jpkg / c.efficiency), 0.0) / kAirHeat;
  out.charge_k = p.air_k + (1.0 - amount.intercooler * p.cooler) * heated_k;
  out.compressor_w = at_least(T(c.kgps), 0.0) * kAirHeat * heated_k;

  // Throttle and overrun valve.
  const T opened = 1.0 - cos(T(0.5 * kPi * throttle));
  const Flow<T> through = nozzle(T(p.leak_m2 + (p.throttle_m2 - p.leak_m2) * opened), charge_pa,
                                 manifold_pa, out.charge_k, out.charge_k);
  out.throttle_kgps = through.kgps;
  T overrun_slope = T(0);
  if (!is_exactly_zero(amount.overrun)) {
    const Sloped<T> open =
        soft_step(T((charge_pa - manifold_pa - p.overrun_pa) / p.overrun_range_pa));
    const Flow<T> full =
        nozzle(T(amount.overrun * p.overrun_m2), charge_pa, p.air_pa, out.charge_k, p.air_k);
    out.overrun_kgps = open.value * full.kgps;
    overrun_slope = open.value * full.per_before + open.slope / p.overrun_range_pa * full.kgps;
  }

  // Cylinders: gas that the last cycle left takes room from the air.
  T room = 1.0 + (1.0 - pow(T(exhaust_pa / manifold_pa), 1.0 / 1.35)) / (p.compression - 1.0);
  room = at_least(room, 0.05);
  const T per_rad = p.displacement_m3 / (4.0 * kPi);  // m3 per rad of the crankshaft
  const T air_per_rad = room * p.filling * per_rad * manifold_pa / (kGas * out.charge_k);
  out.cylinder_kgps = air_per_rad * engine;
  const T fuel_per_air = fuelled / p.air_fuel;
  out.fuel_kgps = out.cylinder_kgps * fuel_per_air;
  const T turning = engine / (engine + 10.0);
  out.engine_nm =
      p.indicated * p.fuel_jpkg * fuel_per_air * air_per_rad -
      turning * per_rad * (p.friction_pa + p.friction_pas * engine + exhaust_pa - manifold_pa);
  // What neither the pistons nor the coolant take leaves with the gas.
  out.exhaust_k = out.charge_k + p.fuel_jpkg * fuel_per_air *
                                     (1.0 - p.indicated - p.coolant_share) /
                                     ((1.0 + fuel_per_air) * kExhaustHeat);

  const Turbine<T> t = turbine(p, amount.wastegate, charge_pa, exhaust_pa, out.exhaust_k, shaft,
                               maps, amount.turbine_map);
  out.turbine_kgps = t.kgps;
  out.wastegate_kgps = t.wastegate_kgps;

  // Shaft. Below 500 rad/s the compressor's torque is that of its power at 500.
  const T compressor_nm = out.compressor_w / at_least(shaft, 500.0);
  out.shaft_nm = t.torque_nm - compressor_nm - p.bearing_nms * shaft;
  out.compressor_w = compressor_nm * shaft;
  out.turbine_w = t.torque_nm * shaft;
  out.bearing_w = p.bearing_nms * shaft * shaft;
  out.shaft_radps2 = out.shaft_nm / p.inertia_kgm2;

  // Volumes.
  const T manifold = kGas * out.charge_k / p.manifold_m3,
          charge = kGas * out.charge_k / p.charge_m3;
  const T exhaust = kGas * out.exhaust_k / p.exhaust_m3;  // Pa/kg
  out.manifold_paps = manifold * (out.throttle_kgps - out.cylinder_kgps);
  out.charge_paps = charge * (out.compressor_kgps - out.throttle_kgps - out.overrun_kgps);
  out.exhaust_paps =
      exhaust * (out.cylinder_kgps + out.fuel_kgps - out.turbine_kgps - out.wastegate_kgps);
  out.drift.manifold = manifold * (through.per_behind - out.cylinder_kgps / manifold_pa);
  out.drift.manifold_charge = manifold * through.per_before;
  out.drift.charge = charge * (c.per_pa - through.per_before - overrun_slope);
  out.drift.charge_manifold = -charge * through.per_behind;
  out.drift.exhaust = -exhaust * t.per_pa;
  return out;
}

/// The air path of an idling engine: throttle closed, what leaks through chokes and the cylinders
/// take it; air around as before and behind, and a turbocharger at 1000 rad/s.
template <class T>
TurboState<T> idling_air_path(const Parameters<T>& p, const T& engine_radps) {
  using P = Parameter;
  using std::sqrt;
  const T air_k = p[P::environment_temperature_k], air_pa = air_pressure(p);
  const T sucked = p[P::engine_filling] * p[P::engine_displacement_m3] * engine_radps /
                   (4.0 * 3.141592653589793 * sqrt(kGas * air_k));
  const T manifold = std::sqrt(0.5) * p[P::intake_leak_m2] * air_pa / sucked;
  return {manifold < 0.5 * air_pa ? manifold : T(0.5 * air_pa), air_pa, air_pa, T(1000)};
}

}  // namespace vehicle::laws
