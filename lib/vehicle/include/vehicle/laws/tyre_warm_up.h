// Tyres that warm up where no temperature is known: one warmth of all tyres, 0 cold to 1.
//
// A first-order approach to 1 whose pace follows the lateral acceleration (own choice: the work of
// the tyres grows with it); `crgexplain` finds loss and time from recordings.
#pragma once

#include <cmath>

#include "vehicle/laws/clip.h"

namespace vehicle::laws {

/// How hard the tyres work, 1 at 6.4 m/s2 across the car: 0.2 + |a| / (8 m/s2), at most 3.
template <class T>
T warm_up_work(const T& lateral_mps2) {
  using std::abs;
  return clip(T(0.2 + abs(lateral_mps2) / 8.0), 0.0, 3.0);
}

/// Rate of the warmth, 1/s.
template <class T>
T warm_up_rate(const T& warmth, const T& time_s, const T& lateral_mps2) {
  return (1.0 - warmth) / time_s * warm_up_work(lateral_mps2);
}

/// The warmth `step_s` later under a lateral acceleration that stays: exact.
template <class T>
T warmth_after(const T& warmth, const T& time_s, const T& lateral_mps2, double step_s) {
  using maths::exp;
  return 1.0 - (1.0 - warmth) * exp(-step_s * warm_up_work(lateral_mps2) / time_s);
}

/// The share of grip that is missing; `loss` is missing when cold.
template <class T>
T warm_up_missing(const T& loss, const T& warmth) {
  return loss * (1.0 - clip(warmth, 0.0, 1.0));
}

/// Factor on the cornering stiffness: half of what grip misses.
template <class T>
T warm_up_stiffness(const T& missing) {
  return 1.0 - 0.5 * missing;
}

}  // namespace vehicle::laws
