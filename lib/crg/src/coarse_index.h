// A first guess at the segment near a map point, from tables small enough for the cache.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "line_geometry.h"

namespace crg {

class CoarseIndex {
 public:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  struct Guess {
    std::size_t segment = kNone;
    float v_m = 0.0F;
  };

  CoarseIndex() = default;
  /// `reach_m`: half width of the strip around the line in which guesses are wanted.
  CoarseIndex(std::span<const SegmentRecord> segments, double reach_m);

  /// A segment near (x, y), kNone far from the line. Usually right to within a few segments where
  /// one leg passes; any leg where several do.
  Guess guess(double x_m, double y_m) const noexcept;

 private:
  // Every 2^shift_-th node: where it lies, and the direction of its segment in segments per metre.
  struct Station {
    float dx_m, dy_m;
    float cos, sin;
  };

  // Cells lie in blocks of 4 x 4, a cache line each: a road crosses few of them.
  std::size_t cell_at(std::size_t row, std::size_t column) const {
    return (row / 4 * blocks_ + column / 4) * 16 + row % 4 * 4 + column % 4;
  }

  double x_min_m_ = 0.0, y_min_m_ = 0.0, per_cell_ = 0.0;
  std::size_t columns_ = 0, rows_ = 0, blocks_ = 0;
  std::vector<std::uint32_t> cells_;  ///< station + 1, or 0
  std::vector<Station> stations_;
  int shift_ = 0;
  float mean_length_m_ = 1.0F;
  std::size_t segments_ = 0;
};

}  // namespace crg
