// One pass of each stretch left out: do the stated deviations hold what it shows beside the others?
#pragma once

#include "node_height.h"

namespace cloud {

inline constexpr std::size_t kLeftOutRows = 8;  // each so many rows: an eighth of the memory

/// Sums of all points, and of each kLeftOutRows-th row once more those of the pass that its stretch
/// leaves out (Drift::apart); empty without passes.
struct RoadSums {
  NodeSums all, left_out;
};

struct LeftOut {
  std::size_t nodes = 0;
  double within_90 = 0.0;     ///< of them, in 90 % intervals of the difference
  double noise_factor = 1.0;  ///< of the points' own deviations, 1 to 2, for 90 % of them to be
  bool is_clear = true;       ///< false: no factor up to 2 is enough
};

/// Heights of the nodes by one pass against those by the others, in deviations of the difference:
/// the points' own noise of both and what is left of the drift between them.
LeftOut look_at_left_out(const RoadSums& sums, const RoadFrame& frame, const Drift& drift,
                         const Noise& noise);

}  // namespace cloud
