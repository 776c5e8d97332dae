// What the path of a car says that its other channels must show, and how well one follows it.
#pragma once

#include <string>
#include <vector>

#include "explain/signals.h"

namespace explain {

struct Match {
  double correlation = 0.0, slope = 0.0;
  double lag_s = 0.0;  ///< positive: later than the reference; between steps by a parabola
  bool known = false;  ///< enough was going on to say
  double at_once = 0;  ///< correlation without a shift
};

/// How `x` follows `reference` at the shift within 3 s at which it does so best; NaN is left out.
/// Unknown where the reference swings by less than `least_swing` (one standard deviation) or fewer
/// than 100 pairs of values are there. A shift wants a clear gain over none.
Match match(const std::vector<double>& x, const std::vector<double>& reference, double least_swing);

/// Of a recording's positions alone, per step; NaN below 6 m/s. `along` is the rate of the logged
/// speed, `slip` wants a heading as well: m/s to the left of the nose.
struct PathSays {
  std::vector<double> turn_radps, along_mps2, slowing_mps2, across_mps2, slip_mps;
  std::vector<double> curvature;  ///< times 3 m: the steering of a car with that wheelbase, rad
};

PathSays path_says(const Signals& s);

/// A turning as `turn_radps` would show it, which is that between two chords.
std::vector<double> between_chords(const std::vector<double>& turning);

/// What is wrong with a logged lateral speed against path and heading: clock, sign, scale, a scale
/// that changes. Empty: nothing, or it cannot be told.
std::string wrong_with_slip(const Signals& s, const PathSays& path);

}  // namespace explain
