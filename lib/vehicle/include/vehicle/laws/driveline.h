// Clutch, gears and differential.
//
// Frictions are Coulomb's, regularised by tanh over a stick speed; settle.h settles what sticks.
#pragma once

#include <cmath>

#include "vehicle/laws/clip.h"
#include "vehicle/maths.h"
#include "vehicle/parameters.h"

namespace vehicle::laws {

/// A friction torque against a slip speed: what acts, N m, the share of it (signed), and how fast
/// it grows with the slip, N m s.
template <class T>
struct SlipFriction {
  T torque_nm, grip, stiffness_nms;
};

template <class T>
SlipFriction<T> slip_friction(const T& capacity_nm, const T& slip_radps, const T& stick_radps) {
  using maths::tanh;
  const T grip = tanh(T(slip_radps / stick_radps));
  return {capacity_nm * grip, grip, capacity_nm * (1.0 - grip * grip) / stick_radps};
}

/// Largest torque of the clutch, N m; a centrifugal one (`amount`) engages with engine speed.
template <class T>
T clutch_capacity(const Parameters<T>& p, const T& amount, const T& engine_radps) {
  using P = Parameter;
  T capacity = p[P::clutch_torque_nm];
  if (!is_exactly_zero(amount)) {
    const T engaged = smooth_step(T((engine_radps - p[P::clutch_begin_radps]) /
                                    (p[P::clutch_full_radps] - p[P::clutch_begin_radps])));
    capacity *= 1.0 + amount * (engaged - 1.0);
  }
  return capacity;
}

/// Torque behind the gears over torque before them and the ratio: the loss is the driven side's.
template <class T>
T gear_efficiency(const T& efficiency, const T& torque_nm) {
  return select(torque_nm > T(0), efficiency, T(1.0 / efficiency));
}

/// Friction torque of the limited slip differential, fully sliding, under a torque `driven_nm`
/// into it: preload and ramps, half of it at each wheel.
template <class T>
T limited_slip_torque(const Parameters<T>& p, const T& amount, const T& driven_nm) {
  using P = Parameter;
  using std::abs;
  const T ramp =
      select(driven_nm > T(0), p[P::differential_drive_ramp], p[P::differential_coast_ramp]);
  return amount * (p[P::differential_preload_nm] + ramp * abs(driven_nm)) * 0.5;
}

}  // namespace vehicle::laws
