// Torque of an engine from its map: limiter, idle control, control of the speed during a shift.
#pragma once

#include <cmath>

#include "vehicle/laws/clip.h"
#include "vehicle/map.h"
#include "vehicle/maths.h"
#include "vehicle/parameters.h"

namespace vehicle::laws {

/// Torque of the engine map, N m: over engine speed and throttle, times engine.torque.
template <class T>
T map_torque(const T& factor, const Map2& torque_nm, const T& engine_radps, const T& throttle) {
  return factor * evaluate(torque_nm, engine_radps, throttle);
}

/// The share of cycles that get fuel: 1 to the limiter's speed, falling to 0 over 2 % of it.
template <class T>
T fuelled_share(const T& limit_radps, const T& engine_radps) {
  const T above = (engine_radps - limit_radps) / (0.02 * limit_radps);
  return 1.0 - clip(above, 0.0, 1.0);
}

/// What the limiter leaves of a torque; a dragging engine drags on.
template <class T>
T limited_torque(const T& torque_nm, const T& fuelled) {
  return select(torque_nm > T(0), T(torque_nm * fuelled), torque_nm);
}

/// What the idle control adds, N m: in proportion to the speed that is missing, never a brake.
template <class T>
T idle_torque(const Parameters<T>& p, const T& engine_radps) {
  using P = Parameter;
  const T idle = p[P::engine_idle_gain_nms] * (p[P::engine_idle_radps] - engine_radps);
  return select(idle < T(0), T(0), idle);
}

/// Engine control between two gears: of the difference to the speed wanted, the share
/// gearbox.rev_match (99 % of it) is gone after the shift, exponentially; the rest of the torque
/// stays the driver's. Precondition: gearbox.shift_s > 0.
template <class T>
T rev_match_torque(const Parameters<T>& p, const T& driver_nm, const T& engine_radps,
                   const T& wanted_radps) {
  using P = Parameter;
  using maths::log;
  const T& share = p[P::gearbox_rev_match];
  const T rate_1ps = -log(T(1.0 - 0.99 * share)) / p[P::gearbox_shift_s];
  return (1.0 - share) * driver_nm +
         p[P::engine_inertia_kgm2] * rate_1ps * (wanted_radps - engine_radps);
}

}  // namespace vehicle::laws
