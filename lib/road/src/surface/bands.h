// What lies beside a chain, and how steadily wide it is. Private to classify_by_shape.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "chains.h"

namespace road {

// "Keeps its distance": this share of the length within this much of the median width.
inline constexpr double kSteadyShare = 0.8;

/// The triangles on one side of a chain and how steadily wide they are.
struct Band {
  std::size_t chain = 0;
  bool on_left = true;
  double length_m = 0.0;
  double width_m = 0.0;            ///< median
  double steady = 0.0;             ///< share of the length near the median width
  double smooth = 0.0;             ///< share of the length near the mean width around it
  std::size_t rings = 0;           ///< cross sections that it joins
  std::vector<double> width_at_m;  ///< per edge of the chain; 0: no triangle beside it
  std::vector<std::uint32_t> triangles;
};

Band band_beside(const FlatSurface& flat, const Fans& fans, const std::vector<Chain>& chains,
                 std::size_t index, bool on_left);

/// Are the bands on the two sides of a chain of one width, edge by edge?
bool as_wide(const Band& left, const Band& right);

}  // namespace road
