// How the wake of another car ends: what lies beyond the map that the vehicle file has of it.
#pragma once

#include <cmath>

#include "vehicle/map.h"

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
  using std::abs;
  using std::pow;
  T left(1);
  if (map.x.size() > 1 && map.x.back() > 0.0 && x_m > T(map.x.back())) {
    const T lengths = x_m / map.x.back();
    if (!(lengths < T(kWakeLengths))) return T(0);
    left = pow(lengths, -2.0 / 3.0);
    if (lengths > T(0.5 * kWakeLengths)) left *= 2.0 - lengths / (0.5 * kWakeLengths);
  }
  const double edge_m = y_m > T(0) ? map.y.back() : -map.y.front();
  if (map.y.size() > 1 && edge_m > 0.0 && abs(y_m) > T(edge_m)) {
    const T widths = abs(y_m) / edge_m;
    if (!(widths < T(2))) return T(0);
    left *= 2.0 - widths;
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
