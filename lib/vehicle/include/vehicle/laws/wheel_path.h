// The path of a wheel whose suspension is given by its points: place, camber and toe over travel.
#pragma once

#include <array>
#include <cstddef>

#include "vehicle/lanes.h"

namespace vehicle {

/// What solve_suspension made of the points: polynomials in the travel without a constant term,
/// left wheel; beyond the range straight lines go on. Not given: the linear kinematics of the
/// parameters.
struct WheelPath {
  static constexpr std::size_t kDegree = 6;
  using Coefficients = std::array<double, kDegree>;  ///< of travel, travel^2, ...
  double range_m = 0.0;                              ///< either way; 0: not given
  Coefficients ahead_m{}, outward_m{};               ///< path of the wheel centre
  Coefficients camber_rad{}, toe_rad{};              ///< change from the static values
  bool given() const { return range_m > 0.0; }
};

/// Value, slope and curvature of one polynomial.
template <class T>
struct AlongTravel {
  T value, slope, curvature;
};

/// Of `c` at `travel_m`, in the unit of the polynomial, per metre, per square metre.
template <class T>
AlongTravel<T> along_travel(const WheelPath::Coefficients& c, double range_m, const T& travel_m) {
  const auto beyond = travel_m > T(range_m) || travel_m < T(-range_m);
  const T x = select(beyond, select(travel_m > T(0), T(range_m), T(-range_m)), travel_m);
  AlongTravel<T> out{T(0), T(0), T(0)};
  for (std::size_t k = WheelPath::kDegree; k-- > 0;) {
    const double n = static_cast<double>(k + 1);
    out.value = out.value * x + c[k];
    out.slope = out.slope * x + n * c[k];
    if (k > 0) out.curvature = out.curvature * x + n * (n - 1.0) * c[k];
  }
  out.value = out.value * x;
  out.value = select(beyond, T(out.value + out.slope * (travel_m - x)), out.value);
  out.curvature = select(beyond, T(0), out.curvature);
  return out;
}

}  // namespace vehicle
