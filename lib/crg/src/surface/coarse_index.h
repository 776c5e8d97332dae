// A first guess at the segment near a map point, from tables small enough for the cache.
#pragma once

#include <algorithm>
#include <bit>
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
  // Every 2^shift_-th node: where it lies, the direction of its segment in segments per metre, and
  // how far the line turns there in a segment.
  struct Station {
    float dx_m, dy_m;
    float cos, sin;
    float turn_rad;
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

// On the station's circle of curvature, without a loop or a branch that cannot be foreseen: the
// queries that follow can then begin while this one waits for memory.
inline CoarseIndex::Guess CoarseIndex::guess(double x_m, double y_m) const noexcept {
  const double dx = x_m - x_min_m_, dy = y_m - y_min_m_;
  // Anywhere within the table; what lies beyond it or is not a number becomes too large.
  const auto column = static_cast<std::size_t>(whole(dx * per_cell_)),
             row = static_cast<std::size_t>(whole(dy * per_cell_));
  if (column >= columns_ || row >= rows_) [[unlikely]]
    return {};
  const std::uint32_t cell = cells_[cell_at(row, column)];
  if (cell == 0) [[unlikely]]
    return {};
  const Station& station = stations_[cell - 1];
  const float ex = static_cast<float>(dx) - station.dx_m,
              ey = static_cast<float>(dy) - station.dy_m;
  const float along = ex * station.cos + ey * station.sin,
              across = ey * station.cos - ex * station.sin;
  const float ahead = along / std::max(1.0F - station.turn_rad * across, 0.25F);
  const float angle = ahead * station.turn_rad;
  const float on = std::min(std::max(ahead - ahead * (angle * angle) * (1.0F / 3.0F), -1e6F), 1e6F);
  // The sign bit makes the conversion round downwards.
  std::ptrdiff_t segment = (static_cast<std::ptrdiff_t>(cell - 1) << shift_) +
                           static_cast<std::int32_t>(on) + (std::bit_cast<std::int32_t>(on) >> 31);
  if (static_cast<std::size_t>(segment) >= segments_) [[unlikely]]
    segment = segment < 0 ? 0 : static_cast<std::ptrdiff_t>(segments_) - 1;
  return {static_cast<std::size_t>(segment), (across - 0.5F * along * angle) * mean_length_m_};
}

}  // namespace crg
