// What the points say of the height of a node over the base, and how uncertain that is.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "drift.h"

namespace cloud {

/// Points scatter as far as they were seen from: classes of range, four to an octave.
inline constexpr std::size_t kRanges = 24;
std::size_t range_class(double range_m);

/// Sums of heights over the base per node; row after row, one row less on a closed road (its last
/// row is its first).
struct NodeSums {
  std::vector<float> points, height, height2;
  std::vector<std::uint8_t> range;  ///< of the classes; 255: that or more, of ten points at least

  NodeSums() = default;
  explicit NodeSums(std::size_t nodes)
      : points(nodes), height(nodes), height2(nodes), range(nodes) {}
  void add(std::size_t node, float height_m, std::uint8_t range_class) {
    points[node] += 1.0f, height[node] += height_m, height2[node] += height_m * height_m;
    range[node] = static_cast<std::uint8_t>(std::min(255, range[node] + range_class));
  }
};

/// The sums of one node.
struct NodeSum {
  double points = 0.0, height = 0.0, height2 = 0.0, range = 0.0;
};
NodeSum sum_at(const NodeSums& sums, std::size_t node);

/// Variance of single heights about their node, m^2: where many points fall, and by class of range
/// where few do.
struct Noise {
  double typical_m2 = 0.0;
  std::array<double, kRanges> few_m2{};
};
Noise noise_of(const NodeSums& sums);

struct NodeHeight {
  NodeSource source = NodeSource::base;  ///< base: nothing
  double mean = 0.0, variance = 0.0;     ///< of the node by itself
};

/// By its own points.
NodeHeight measured(const NodeSum& sum, const Noise& noise);
/// In a gap among nodes with at least so many points.
NodeHeight between_neighbours(const NodeSums& sums, std::size_t row, std::size_t column,
                              const RoadFrame& frame, float least, const Noise& noise);

/// Variance of grass too low to be told from a rough road, m^2.
double variance_of_grass(const Sections& sections, const RoadFrame& frame, std::size_t row,
                         double v_m);

/// Variance that a node's height has in common with its neighbours and with the base, which holds
/// the poses: what is left of the drift.
double variance_in_common(const StretchDeviation& left, const RoadFrame& frame, std::size_t row,
                          double v_m);

}  // namespace cloud
