// A double as a float that is certainly not on the wrong side of it.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace crg {

/// The largest float that is not above a value: of +inf the largest finite one, of NaN -inf.
inline float float_below(double value) {
  constexpr double kMax = static_cast<double>(std::numeric_limits<float>::max());
  if (!(std::abs(value) <= kMax))
    return value > 0.0 ? std::numeric_limits<float>::max()
                       : -std::numeric_limits<float>::infinity();
  const float rounded = static_cast<float>(value);
  if (static_cast<double>(rounded) <= value) return rounded;
  // One step down: floats of one sign follow each other as their bits do. Not std::nextafter, which
  // is a call of the C library.
  const auto bits = std::bit_cast<std::uint32_t>(rounded);
  if (rounded == 0.0F) return -std::numeric_limits<float>::denorm_min();
  return std::bit_cast<float>(rounded > 0.0F ? bits - 1 : bits + 1);
}

/// The smallest float that is not below a value: of -inf the lowest finite one, of NaN +inf.
inline float float_above(double value) { return -float_below(-value); }

/// The float next to a value that is not farther from zero.
inline float float_inward(double value) {
  return value < 0.0 ? float_above(value) : float_below(value);
}

}  // namespace crg
