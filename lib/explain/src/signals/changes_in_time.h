// Columns that are right for part of a drive.
#pragma once

#include <optional>
#include <vector>

namespace explain {

/// No speed changes by more against another one of the same car: slip is less on average.
inline constexpr double kSpeedChanges = 1.04;

/// Below it a car may stand: speeds are not held against each other.
inline constexpr double kMayStand_mps = 6.0;

/// A value that is one before a time and another one after it.
struct Change {
  double time_s = 0.0, before = 0.0, after = 0.0;
};

/// Where the slope of `x` on `reference` (both per step; NaN is left out) becomes `counts` times as
/// large or small and stays so: by windows of 10 s in which the reference swings by `least_swing`
/// and x follows it, at least two on either side. None where the slopes of one side differ among
/// themselves by over half of the change. `lag_s`: how late x is.
std::optional<Change> slope_changes(const std::vector<double>& x,
                                    const std::vector<double>& reference, double least_swing,
                                    double lag_s, double counts);

/// The same of the ratio of `x` to what is expected of it (per step; NaN is left out), by windows
/// with at least 2.5 s of both. A fifth of the windows on either side may differ by more.
std::optional<Change> ratio_changes(const std::vector<double>& x,
                                    const std::vector<double>& expected, double counts);

/// From first to last step, what the zero of `x` drifts by against `reference`: of its means over
/// 10 s less those of the reference, the part that grows with time, beside one that goes with the
/// reference, where it is more than ten of its standard errors; else none. At least 60 s.
std::optional<Change> drifts(const std::vector<double>& x, const std::vector<double>& reference);

}  // namespace explain
