// Burn of fuel.
#pragma once

#include "vehicle/parameters.h"

namespace vehicle::laws {

/// Fuel that a useful power takes, kg/s, beside that for idling: the power over efficiency and
/// heating value (Willans' line, as in L. Guzzella and C. H. Onder, Introduction to Modeling and
/// Control of Internal Combustion Engine Systems, 2nd edition 2010, chapter 2).
template <class T>
T fuel_for_work(const Parameters<T>& p, const T& useful_w) {
  using P = Parameter;
  return useful_w / (p[P::fuel_efficiency] * p[P::fuel_energy_jpkg]);
}

/// Fuel that burns, kg/s, at a torque of the engine map; below 0: idling alone.
template <class T>
T fuel_kgps(const Parameters<T>& p, const T& torque_nm, const T& engine_radps) {
  const T useful = select(torque_nm > T(0), T(torque_nm * engine_radps), T(0));
  return p[Parameter::fuel_idle_kgps] + fuel_for_work(p, useful);
}

}  // namespace vehicle::laws
