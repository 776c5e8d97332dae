// The trivial predictor that goes on as it went last.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace vehicle {

/// How much of the past a trend looks at, s.
inline constexpr double kTrend_s = 0.2;

/// The straight line through the samples of the last kTrend_s before `row`, that one included:
/// value at `row`'s time and slope per second. `first`: no sample before it counts. Samples that
/// are NaN are left out; with one sample the slope is 0, with none the value is NaN.
std::pair<double, double> trend(const std::vector<double>& time_s,
                                const std::vector<double>& values, std::size_t row,
                                std::size_t first);

}  // namespace vehicle
