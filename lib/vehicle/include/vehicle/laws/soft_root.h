// A root and a step without kinks, with their slopes: what flows through openings follow.
#pragma once

#include <cmath>

#include "vehicle/lanes.h"

namespace vehicle::laws {

/// A value and how fast it grows.
template <class T>
struct Sloped {
  T value, slope;

  friend Sloped select(const Flag<T>& which, const Sloped& a, const Sloped& b) {
    return {vehicle::select(which, a.value, b.value), vehicle::select(which, a.slope, b.slope)};
  }
};

/// The square root of x, but of finite slope below `small`: odd, smooth to the first derivative,
/// straight through zero but for a term of the second order.
template <class T>
Sloped<T> soft_root(const T& x, double small) {
  using std::abs;
  using std::sqrt;
  const T size = abs(x);
  const auto steep = [&] {
    const T root = sqrt(size);
    return Sloped<T>{select(x < T(0), T(-root), root), 0.5 / root};
  };
  const auto soft = [&] {
    const double root = std::sqrt(small);
    return Sloped<T>{x / root * (1.5 - 0.5 / small * size), (1.5 - size / small) / root};
  };
  return choose(size < T(small), soft, steep);
}

/// Rises from 0 to 1 over [0, 1] without a kink.
template <class T>
Sloped<T> soft_step(const T& x) {
  const auto between = [&] { return Sloped<T>{x * x * (3.0 - 2.0 * x), 6.0 * x * (1.0 - x)}; };
  const auto ends = [&] { return Sloped<T>{select(x >= T(1), T(1), T(0)), T(0)}; };
  return choose(x > T(0) && x < T(1), between, ends);
}

}  // namespace vehicle::laws
