// What the road under the wheels scatters by the angle at which the sensor looks at it.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "sections.h"

namespace cloud {

/// Knots at the angles that cells of the lane were seen at, linear in the octaves of the sine's
/// square between them.
class LaneScatter {
 public:
  void add(const SectionCell& cell);
  /// After the last one. Bins with few cells get no knot.
  void close();
  /// Mean square per degree of freedom that a cell of the lane would have; 0 without a lane.
  double at_m2(const SectionCell& cell) const;
  /// The same by the nearest bin: while the poses drift, what scatters by angle is no smooth line.
  double in_bin_m2(const SectionCell& cell) const;

 private:
  static constexpr std::size_t kBins = 12;
  struct Bin {
    double freedom = 0.0, square_m2 = 0.0, octaves = 0.0;
  };
  static double octaves_of(const SectionCell& cell);
  std::array<Bin, kBins> bins_{};
  std::vector<double> octaves_, per_freedom_m2_;  ///< of the knots, ascending
  std::array<double, kBins> nearest_m2_{};
};

}  // namespace cloud
