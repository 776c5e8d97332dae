// Work that a tyre's spring takes up where the plane under its wheel turns between two steps.
#pragma once

#include <cmath>

#include "vehicle/magic_formula.h"
#include "vehicle/vec3.h"

namespace vehicle::laws {

/// What is kept of a wheel's last step.
template <class T>
struct Ledge {
  Flag<T> known = false;        ///< whether there was one
  Vec3<Real<T>> hub_m, normal;  ///< place of the hub, normal of the road's plane; map frame
  Real<T> radius_m = 0.0;       ///< from the plane to the hub
  T pressed_m = T(0);           ///< deflection that pressed
  T sunk_m = T(0);              ///< deflection that nothing has paid for: it does not press
  T lent_j = T(0);              ///< work taken that may be given back
  Vec3<Real<T>> lent_at_m;      ///< where the hub was when it was last taken
};

/// All that planes would have done by turning, had it not been taken from the motion.
struct LedgeTotal {
  double work_j = 0.0;
  double most_j = 0.0, u_m = 0.0, v_m = 0.0;  ///< of one step, and where
};

inline void count(LedgeTotal& total, double work_j, double u_m, double v_m) {
  if (work_j > 0.0) total.work_j += work_j;
  if (work_j > total.most_j) total = {total.work_j, work_j, u_m, v_m};
}

/// A plane that turns by less than this deflection in a step is a smooth road.
inline constexpr double kLedge_m = 2e-4;

/// A plane whose normal leans forward by more than this falls away under the wheel: no road for
/// cars is that steep.
inline constexpr double kFallsAway = 0.3;

/// What the spring holds more at one deflection than at another, both at least 0, J. Simpson's
/// rule: exact for the quadratic load of the Magic Formula.
template <class T>
T spring_work(const TyreCoefficients& tyre, const T& from_m, const T& to_m, const T& spin_radps,
              const T& pressure_pa) {
  constexpr int kPanels = 4;
  const T step = (to_m - from_m) / static_cast<double>(2 * kPanels);
  T sum = T(0);
  for (int k = 0; k <= 2 * kPanels; ++k) {
    const double weight = k == 0 || k == 2 * kPanels ? 1.0 : (k % 2 == 0 ? 2.0 : 4.0);
    sum += weight *
           tyre_load(tyre, T(from_m + static_cast<double>(k) * step), spin_radps, pressure_pa);
  }
  return sum * step / 3.0;
}

/// The impulse against a motion of `speed_mps` that takes `work_j` from it (below 0: gives), where
/// a unit impulse changes that speed by `per_mass_1pkg`. What is asked must be there.
template <class T>
T impulse_for(const T& work_j, const T& speed_mps, const T& per_mass_1pkg) {
  using std::sqrt;
  const T left = speed_mps * speed_mps - 2.0 * per_mass_1pkg * work_j;
  return (speed_mps - (left > T(0) ? T(sqrt(left)) : T(0))) / per_mass_1pkg;
}

}  // namespace vehicle::laws
