// Half widths of 90 % intervals.
#pragma once

#include <algorithm>
#include <cmath>

namespace base {

/// Standard deviations of the normal distribution to either side of a 90 % interval.
inline constexpr double kNormal90 = 1.645;

/// The same with `freedom` degrees of freedom: the quantile of Student's t at 95 % by its expansion
/// (M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions, 26.7.5), within 0.3 % from 3
/// on; below 1 as 1.
inline double t90(double freedom) {
  const double z = 1.6448536269514722, n = std::max(1.0, freedom), z3 = z * z * z;
  return z + (z3 + z) / (4.0 * n) + (5.0 * z3 * z * z + 16.0 * z3 + 3.0 * z) / (96.0 * n * n) +
         (3.0 * std::pow(z, 7) + 19.0 * std::pow(z, 5) + 17.0 * z3 - 15.0 * z) /
             (384.0 * n * n * n);
}

/// Half of the interval of a number from two sources: the standard deviations of what a sample
/// leaves open, with so many degrees of freedom, and of what was known before.
inline double half_width_90(double freedom, double sd_sample, double sd_known) {
  return std::hypot(t90(freedom) * sd_sample, kNormal90 * sd_known);
}

}  // namespace base
