// Bounds that keep derivatives: what the other laws share.
#pragma once

#include "vehicle/lanes.h"

namespace vehicle::laws {

/// x clipped to [low, high]; the derivative is zero outside.
template <class T>
T clip(const T& x, double low, double high) {
  return select(x < T(low), T(low), select(x > T(high), T(high), x));
}

/// Rises from 0 to 1 over [0, 1] without a kink.
template <class T>
T smooth_step(const T& x) {
  const T c = clip(x, 0.0, 1.0);
  return c * c * (3.0 - 2.0 * c);
}

}  // namespace vehicle::laws
