// How one signal goes with another, and what a path says of speed and turning. Private.
#pragma once

#include <vector>

namespace explain {

/// Slope of y over x through zero, and the correlation.
struct Fit {
  double slope = 0.0, correlation = 0.0;
};
Fit through_zero(const std::vector<double>& x, const std::vector<double>& y);

/// What the path says: course, its rate, speed. Central differences over 0.4 s; rad, rad/s,
/// m/s, m/s2, NaN where nothing can be said.
struct Path {
  std::vector<double> course, rate, speed, acceleration;
};
Path path_of(const std::vector<double>& t, const std::vector<double>& x,
             const std::vector<double>& y);

/// The change of a speed over 0.3 s, in m/s2; NaN in gaps.
std::vector<double> acceleration_of(const std::vector<double>& t, const std::vector<double>& speed);

}  // namespace explain
