// What varies in the rows of a tyre beside slip.
#pragma once

#include <array>
#include <numbers>

#include "identify/tyre_fit.h"
#include "vehicle/magic_formula.h"

namespace identify {

inline constexpr double kDegree = std::numbers::pi / 180.0;

struct Varied {
  /// By Needs: between the 5 % and the 95 % row 0.2 nominal loads, 1 degree of camber, 5 % of the
  /// nominal pressure.
  std::array<bool, 4> by_need{true, false, false, false};
  /// Camber varies, but not by 1 degree beside what side slip and load tell of it: on a drive it is
  /// the body's roll, and whatever it does to the force looks like side slip.
  bool camber_follows = false;
};

Varied varied(const TyreSamples& rows, const vehicle::TyreCoefficients& reference);

}  // namespace identify
