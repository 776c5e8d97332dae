// Brake pads: torque of a disc brake, and fade by the heat that the pads hold.
#pragma once

#include "vehicle/laws/clip.h"
#include "vehicle/map.h"

namespace vehicle::laws {

/// Friction of the pads: `constant`, or that of the map over pressure and surface temperature where
/// there is one and `amount` is 1.
template <class T>
T pad_friction(const T& constant, const T& amount, const Map2& map, const T& pressure_pa,
               const T& surface_k) {
  if (map.empty()) return constant;
  return constant + amount * (evaluate(map, pressure_pa, surface_k) - constant);
}

/// Torque of one fully sliding brake, N m: two faces, each pressed by pistons of `area_m2` at
/// `pressure_pa` and rubbing at `radius_m` (the definition of the pads' friction). `pressure_pa`
/// from 0.
template <class T>
T brake_torque(const T& friction, const T& pressure_pa, const T& area_m2, const T& radius_m) {
  return 2.0 * friction * pressure_pa * area_m2 * radius_m;
}

/// What fade leaves of the pads' friction, 1 when cold: `fade_1pmj` is lost per megajoule that the
/// pads of all wheels hold; at most 95 % is lost and at most as much again gained (below 0: pads
/// that bite better when hot). `amount` 0 to 1. A straight line through the cold state: the first
/// term of any law of fade (own choice; no rate constants of racing pads are published).
template <class T>
T pad_bite(const T& amount, const T& fade_1pmj, const T& heat_j) {
  return 1.0 - amount * clip(T(1e-6 * fade_1pmj * heat_j), -1.0, 0.95);
}

/// How fast that heat grows, W: by the power of all brakes, less what leaves with `time_s`.
template <class T>
T pad_heat_rate(const T& brakes_w, const T& heat_j, const T& time_s) {
  return brakes_w - heat_j / time_s;
}

}  // namespace vehicle::laws
