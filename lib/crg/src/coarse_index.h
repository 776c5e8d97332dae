// A first guess at the segment near a map point, from a coarse grid small enough for the cache.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "line_geometry.h"

namespace crg {

class CoarseIndex {
 public:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  CoarseIndex() = default;
  /// `reach_m`: half width of the strip around the line in which guesses are wanted.
  CoarseIndex(const std::vector<SegmentFrame>& frames, double reach_m);

  /// A segment near (x, y), or kNone far from the line. Usually right to within a few segments
  /// where one leg passes; any leg where several do.
  std::size_t guess(double x_m, double y_m) const noexcept;

 private:
  struct Station {
    float dx_m, dy_m;      // from the origin
    float cos, sin;
    float per_metre;       // segments per metre
    std::uint32_t segment;
  };

  double x_min_m_ = 0.0, y_min_m_ = 0.0, per_cell_ = 0.0;
  std::size_t columns_ = 0, rows_ = 0;
  std::vector<std::uint32_t> cells_;  ///< station + 1, or 0
  std::vector<Station> stations_;
};

}  // namespace crg
