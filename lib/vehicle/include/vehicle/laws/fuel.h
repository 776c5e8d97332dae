// Burn of fuel.
#pragma once

#include "vehicle/parameters.h"

namespace vehicle::laws {

/// Fuel that burns, kg/s, at a torque of the engine map (below 0: none for it): idling, and the
/// useful power over efficiency and heating value (Willans' line, as in L. Guzzella and C. H.
/// Onder, Introduction to Modeling and Control of Internal Combustion Engine Systems, 2nd edition
/// 2010, chapter 2).
template <class T>
T fuel_kgps(const Parameters<T>& p, const T& torque_nm, const T& engine_radps) {
  using P = Parameter;
  const T useful = torque_nm > T(0) ? T(torque_nm * engine_radps) : T(0);
  return p[P::fuel_idle_kgps] + useful / (p[P::fuel_efficiency] * p[P::fuel_energy_jpkg]);
}

}  // namespace vehicle::laws
