// The contact patch of a tyre with a flexible carcass, one direction at a time.
//
// A string-like first order: the patch is carried through at the speed of travel and takes up a
// deflection u with rate = sliding - transport (u + tau rate) / sigma (H. B. Pacejka, Tire and
// Vehicle Dynamics, 3rd edition, 2012, chapters 5 and 7), sigma the relaxation length and tau the
// damping of the carcass over its stiffness. Steady slip is as without. The limits below are own
// choices for a standing and a sliding tyre.
#pragma once

#include <cmath>

#include "vehicle/laws/clip.h"
#include "vehicle/parameters.h"

namespace vehicle::laws {

inline constexpr double kLargestSlip = 1.5;      ///< the tyre formula is asked for no more
inline constexpr double kSlowSliding_mps = 3.0;  ///< from here down the carcass's own limit acts
inline constexpr double kUnwinding_s = 0.005;    ///< with which it loses what is beyond that

/// Speed at which the patch is renewed, m/s: that of travel; but its deflection never exceeds what
/// a slip of kLargestSlip gives: below a certain speed it is the sliding that renews it.
template <class T>
T patch_transport(const T& travel_mps, const T& sliding_mps) {
  using std::abs;
  return larger(travel_mps, T(abs(sliding_mps) / kLargestSlip));
}

/// How fast a deflection decays, 1/s, and what part of the sliding it takes up, less by damping.
template <class T>
struct PatchLag {
  T decay_1ps, yield;
};

template <class T>
PatchLag<T> patch_lag(const T& transport_mps, const T& sigma_m, const T& damping_s) {
  PatchLag<T> out{transport_mps / sigma_m, T(1)};
  if (!is_exactly_zero(damping_s)) {
    out.yield = 1.0 / (1.0 + damping_s * out.decay_1ps);
    out.decay_1ps *= out.yield;
  }
  return out;
}

/// More decay, 1/s, of a deflection that the carcass cannot hold: it holds no more than friction
/// over its stiffness (`held_slip`, as a slip); what fast sliding adds to the deflection is no
/// spring and must not push on once the sliding ends. So the most that a slowly sliding patch keeps
/// shrinks to the carcass's own with `pace_mps`, the greater of travel and sliding.
template <class T>
T patch_unwinding(const T& pace_mps, const T& held_slip, const T& sigma_m, const T& deflection_m) {
  using std::abs;
  const T held = smaller(T(kLargestSlip), held_slip);
  const T most =
      (held + (kLargestSlip - held) * smooth_step(T(pace_mps / kSlowSliding_mps))) * sigma_m;
  const T size = abs(deflection_m);
  return choose(
      size > most, [&] { return T((1.0 - most / size) / kUnwinding_s); }, [] { return T(0); });
}

}  // namespace vehicle::laws
