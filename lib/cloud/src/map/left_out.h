// One pass of each stretch left out: do the stated deviations hold what it shows beside the others?
#pragma once

#include "node_height.h"

namespace cloud {

inline constexpr std::size_t kLeftOutRows = 8;  // each so many rows: an eighth of the memory

/// Sums of all points, and of each kLeftOutRows-th row once more those of the pass that its stretch
/// leaves out (Drift::apart); of no row where no stretch does.
class RoadSums {
 public:
  RoadSums(const RoadFrame& frame, const Drift& drift);
  /// No two threads in one stripe of `all`.
  void add(std::size_t node, int pass, float height_m, std::uint8_t range_class);
  /// Adds what other points say. Throws Error where `other` is of another road.
  void add(const RoadSums& other);

  NodeSums all, left_out;          ///< a stripe of `left_out` has the rows of one of `all`
  std::size_t read = 0, used = 0;  ///< points

 private:
  RoadSums(const RoadFrame& frame, std::vector<int> passes);
  std::size_t columns_;
  std::vector<int> passes_;  ///< that are left out, per row of left_out
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
