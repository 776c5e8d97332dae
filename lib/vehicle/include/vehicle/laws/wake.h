// How the wake of another car ends: what lies beyond the map that the vehicle file has of it.
#pragma once

#include <cmath>

#include "vehicle/map.h"
#include "vehicle/maths.h"

namespace vehicle::laws {

/// Own choice: no wake outlasts the air's own turbulence; it has faded at this many lengths of its
/// map, from half of them on, and at two half widths.
inline constexpr double kWakeLengths = 10.0;

/// What is left at (x, y) m of the deficit that a map of the wake ends with: 1 on the map, 0 far
/// from it. Behind, the deficit of speed in a turbulent wake of a body falls with distance^(-2/3)
/// (H. Tennekes, J. L. Lumley, A First Course in Turbulence, 1972, section 4.2, axisymmetric), and
/// what it takes of drag and lift, twice the deficit as long as that is small, with it.
template <class T>
T wake_left(const Map2& map, const T& x_m, const T& y_m) {
  using maths::pow;
  using std::abs;
  const auto one = [] { return T(1); };
  T left(1);
  if (map.x.size() > 1 && map.x.back() > 0.0) {
    const auto faded = [&] {
      const T lengths = x_m / map.x.back();
      const T law = pow(lengths, -2.0 / 3.0);
      const T end = select(lengths > T(0.5 * kWakeLengths),
                           T(law * (2.0 - lengths / (0.5 * kWakeLengths))), law);
      return select(lengths < T(kWakeLengths), end, T(0));
    };
    left = choose(x_m > T(map.x.back()), faded, one);
  }
  if (map.y.size() > 1) {
    const T edge_m = select(y_m > T(0), T(map.y.back()), T(-map.y.front()));
    const T size = abs(y_m);
    const auto beside = [&] {
      const T widths = size / edge_m;
      return select(widths < T(2), T(2.0 - widths), T(0));
    };
    left = left * choose(edge_m > T(0) && size > edge_m, beside, one);
  }
  return left;
}

/// The factor that a map of the wake gives for a car that has another at (x, y) m in its own frame;
/// 1 without a map. Precondition: checked.
template <class T>
T wake_factor(const T& amount, const Map2& map, const T& x_m, const T& y_m) {
  if (map.empty()) return T(1);
  const T left = wake_left(map, x_m, y_m);
  return 1.0 + (amount * left) * (evaluate(map, x_m, y_m) - 1.0);
}

}  // namespace vehicle::laws
