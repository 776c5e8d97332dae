// Temperatures of a brake disc: friction layers and core, each of one temperature.
//
// Two nodes as in R. Limpert, Brake Design and Safety, 2nd edition (SAE 1999); radiation
// by Stefan and Boltzmann as of a grey body among walls as warm as the air. Convection: one Nusselt
// number by the Reynolds numbers of disc and car, each to the power 0.8, or faces and vanes apart
// by laws/brake_disc.h.
#pragma once

#include <cmath>
#include <cstddef>

#include "vehicle/laws/brake_disc.h"
#include "vehicle/laws/clip.h"
#include "vehicle/parameters.h"

namespace vehicle::laws {

inline constexpr double kStefanBoltzmann = 5.670374419e-8;  ///< W/(m2 K4), CODATA 2018
inline constexpr double kConductanceReference_k = 500.0;    ///< where the stated conductance holds
inline constexpr double kCapacityReference_k = 300.0;       ///< where the stated capacities hold

/// Of one disc; names and units as in parameters.def and axle_parameters.def.
template <class T>
struct DiscParameters {
  T disc_share, conductance_wpk, conductance_slope_1pk;
  T surface_capacity_jpk, core_capacity_jpk, capacity_slope_1pk;
  T diameter_m, area_m2, inner_m, vane_diameter_m, vane_area_m2;
  T nusselt_still, nusselt_car, nusselt_disc, air_share, emissivity;
  T air_k;
};

/// Axle 0: front, 1: rear.
template <class T>
DiscParameters<T> disc_parameters(const Parameters<T>& p, std::size_t axle) {
  using P = Parameter;
  return {p[P::brake_disc_share],
          p.axle(axle, P::front_disc_conductance_wpk),
          p[P::brake_conductance_slope_1pk],
          p.axle(axle, P::front_disc_surface_capacity_jpk),
          p.axle(axle, P::front_disc_core_capacity_jpk),
          p[P::brake_capacity_slope_1pk],
          p.axle(axle, P::front_disc_diameter_m),
          p.axle(axle, P::front_disc_area_m2),
          p.axle(axle, P::front_disc_inner_m),
          p.axle(axle, P::front_vane_diameter_m),
          p.axle(axle, P::front_vane_area_m2),
          p[P::brake_nusselt_still],
          p[P::brake_nusselt_car],
          p[P::brake_nusselt_disc],
          p[P::brake_air_share],
          p[P::brake_emissivity],
          p[P::environment_temperature_k]};
}

/// How much of each part acts, 0 to 1; the terms brake_heating and so on.
template <class T>
struct DiscAmounts {
  T heating = T(0), conduction = T(0), convection = T(0), vanes = T(0), radiation = T(0),
    heat_capacity = T(0);
  /// Whether the one law of convection has a share.
  bool blown_as_one() const {
    return !is_exactly_zero(convection) && !is_exactly_zero(T(1.0 - vanes));
  }
};

/// The air that the moving car brings to the discs of an axle: its speed, and what it adds to the
/// Nusselt number of the one law.
template <class T>
struct DiscAir {
  T speed_mps, nusselt;
};

template <class T>
DiscAir<T> disc_air(const DiscParameters<T>& p, const DiscAmounts<T>& amount, const T& speed_mps) {
  using maths::pow;
  if (!amount.blown_as_one()) return {speed_mps, T(0)};
  return {speed_mps, p.nusselt_car * pow(T(speed_mps * p.diameter_m / kAirViscosity + 1e-9), 0.8)};
}

/// Heat that leaves, W: the friction layers through the faces and by the one law, the core through
/// the vanes.
template <class T>
struct DiscCooling {
  T faces_w = T(0), as_one_w = T(0), vanes_w = T(0);
};

/// Convection at a speed of the disc `spin_radps`, either way.
template <class T>
DiscCooling<T> disc_convection(const DiscParameters<T>& p, const DiscAmounts<T>& amount,
                               const T& surface_k, const T& core_k, const T& spin_radps,
                               const DiscAir<T>& air) {
  using maths::pow;
  using std::abs;
  DiscCooling<T> out;
  if (is_exactly_zero(amount.convection)) return out;
  const bool vanes = !is_exactly_zero(amount.vanes);
  const T& d = p.diameter_m;
  const T turning = abs(spin_radps);
  if (vanes) {
    const T k = amount.convection * amount.vanes;
    const T& gap = p.vane_diameter_m;
    out.faces_w = k *
                  disc_face_nusselt(d, turning, T(p.air_share * air.speed_mps), p.nusselt_still) *
                  kAirConductivity / d * p.area_m2 * (surface_k - p.air_k);
    out.vanes_w = k *
                  vane_nusselt(gap, T(0.5 * (d - p.inner_m)), vane_air_mps(d, p.inner_m, turning)) *
                  kAirConductivity / gap * p.vane_area_m2 * (core_k - p.air_k);
  }
  if (amount.blown_as_one()) {
    const T disc_speed = turning * d * 0.5;
    const T nusselt = p.nusselt_still + air.nusselt +
                      p.nusselt_disc * pow(T(disc_speed * d / kAirViscosity + 1e-9), 0.8);
    const T out_w =
        amount.convection * nusselt * kAirConductivity / d * p.area_m2 * (surface_k - p.air_k);
    out.as_one_w = vanes ? T((1.0 - amount.vanes) * out_w) : out_w;
  }
  return out;
}

template <class T>
struct DiscRates {
  T surface_kps, core_kps;
};

/// How fast both temperatures rise under a brake torque `brake_nm` (against the turning) at
/// `spin_radps`. The relative changes of conductance and heat capacities with temperature are held
/// to 0.05 to 100 and 0.2 to 100.
template <class T>
DiscRates<T> disc_heat(const DiscParameters<T>& p, const DiscAmounts<T>& amount, const T& surface_k,
                       const T& core_k, const T& brake_nm, const T& spin_radps,
                       const DiscAir<T>& air) {
  T into_surface = T(0), into_core = T(0);
  if (!is_exactly_zero(amount.heating))
    into_surface -= amount.heating * p.disc_share * brake_nm * spin_radps;
  if (!is_exactly_zero(amount.conduction)) {
    T flow = amount.conduction * p.conductance_wpk * (surface_k - core_k);
    flow *= clip(
        T(1.0 + p.conductance_slope_1pk * (0.5 * (surface_k + core_k) - kConductanceReference_k)),
        0.05, 100.0);
    into_surface -= flow;
    into_core += flow;
  }
  const DiscCooling<T> cooling = disc_convection(p, amount, surface_k, core_k, spin_radps, air);
  into_surface -= cooling.faces_w;
  into_core -= cooling.vanes_w;
  into_surface -= cooling.as_one_w;
  if (!is_exactly_zero(amount.radiation)) {
    const T s2 = surface_k * surface_k, a2 = p.air_k * p.air_k;
    into_surface -=
        amount.radiation * kStefanBoltzmann * p.emissivity * p.area_m2 * (s2 * s2 - a2 * a2);
  }
  T capacity_surface = p.surface_capacity_jpk, capacity_core = p.core_capacity_jpk;
  if (!is_exactly_zero(amount.heat_capacity)) {
    const T slope = amount.heat_capacity * p.capacity_slope_1pk;
    capacity_surface *= clip(T(1.0 + slope * (surface_k - kCapacityReference_k)), 0.2, 100.0);
    capacity_core *= clip(T(1.0 + slope * (core_k - kCapacityReference_k)), 0.2, 100.0);
  }
  return {into_surface / capacity_surface, into_core / capacity_core};
}

}  // namespace vehicle::laws
