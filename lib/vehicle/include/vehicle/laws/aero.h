// Aerodynamic forces by areas and dynamic pressure, with factors from maps.
#pragma once

#include "vehicle/map.h"
#include "vehicle/parameters.h"

namespace vehicle::laws {

/// What a map makes of a force: 1 where there is none or `amount` is 0.
template <class T>
T map_factor(const T& amount, const Map1& map, const T& x) {
  return map.empty() ? T(1) : T(1.0 + amount * (evaluate(map, x) - 1.0));
}
template <class T>
T map_factor(const T& amount, const Map2& map, const T& x, const T& y) {
  return map.empty() ? T(1) : T(1.0 + amount * (evaluate(map, x, y) - 1.0));
}

/// Of air at a speed, Pa.
template <class T>
T dynamic_pressure(const T& density_kgpm3, const T& air_mps) {
  return 0.5 * density_kgpm3 * air_mps * air_mps;
}

/// Drag over the air speed, N s/m, and downforce of both axles, N: half the density times area
/// times the square of the air speed (the definition of the areas).
template <class T>
struct AirForces {
  T drag_nspm, front_n, rear_n;
};

template <class T>
AirForces<T> air_forces(const Parameters<T>& p, const T& air_mps, const T& air_mps2) {
  using P = Parameter;
  const T half_density = 0.5 * p[P::aero_density_kgpm3];
  return {half_density * p[P::aero_drag_area_m2] * air_mps,
          half_density * p[P::front_lift_area_m2] * air_mps2,
          half_density * p[P::rear_lift_area_m2] * air_mps2};
}

/// Side force, N, left positive, at an air speed `air_mps`, of which the car moves with
/// `leftward_mps` to the left through the air.
template <class T>
T side_force(const Parameters<T>& p, const T& amount, const T& air_mps, const T& leftward_mps) {
  using P = Parameter;
  const T half_density = 0.5 * p[P::aero_density_kgpm3];
  return -amount * half_density * p[P::aero_side_area_m2] * air_mps * leftward_mps;
}

}  // namespace vehicle::laws
