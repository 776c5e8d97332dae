// Which rows something happened in, as ranges of u.
#pragma once

#include <vector>

#include "road/sample.h"

namespace road {

/// Flagged rows closer than 2 m to each other are one range.
inline std::vector<URange> ranges_of(const std::vector<char>& flags, double u_step_m) {
  std::vector<URange> ranges;
  constexpr double kJoin_m = 2.0;
  for (std::size_t i = 0; i < flags.size(); ++i) {
    if (flags[i] == 0) continue;
    const double u = static_cast<double>(i) * u_step_m;
    if (!ranges.empty() && u - ranges.back().u_end_m <= kJoin_m) {
      ranges.back().u_end_m = u;
    } else {
      ranges.push_back({u, u});
    }
  }
  return ranges;
}

}  // namespace road
