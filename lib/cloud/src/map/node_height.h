// What the points say of the height of a node over the base, and how uncertain that is.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "cloud/map.h"
#include "drift.h"

namespace cloud {

/// Points scatter as far as they were seen from: classes of range, four to an octave.
inline constexpr std::size_t kRanges = 24;
std::size_t range_class(double range_m);

/// Of the points next to a node: how many, their heights over the base and the squares of these,
/// and their classes of range.
struct NodeSum {
  float points = 0.0f, height = 0.0f, height2 = 0.0f;
  std::uint8_t range = 0;  ///< 255: that or more, of ten points at least

  void add(float height_m, std::uint8_t range_class) {
    add({1.0f, height_m, height_m * height_m, range_class});
  }
  void add(const NodeSum& other) {
    points += other.points, height += other.height, height2 += other.height2;
    range = static_cast<std::uint8_t>(std::min(255, range + other.range));
  }
};

/// Sums per node; row after row, one row less on a closed road (its last row is its first). Only
/// stripes of rows on which points fell take memory.
class NodeSums {
 public:
  static constexpr std::size_t kStripeRows = 64;

  NodeSums(std::size_t rows, std::size_t columns, std::size_t stripe_rows = kStripeRows);
  std::size_t size() const { return rows_ * columns_; }  ///< nodes
  const NodeSum& operator[](std::size_t node) const {
    const std::vector<NodeSum>& stripe = stripes_[node / in_stripe_];
    return stripe.empty() ? kNothing : stripe[node % in_stripe_];
  }
  /// The same to be written; no two threads in one stripe.
  NodeSum& filled(std::size_t node) { return filled_stripe(node / in_stripe_)[node % in_stripe_]; }
  std::size_t stripes() const { return stripes_.size(); }
  /// Empty where no point fell; else as many rows as a stripe has, of the last as there are.
  const std::vector<NodeSum>& stripe(std::size_t index) const { return stripes_[index]; }
  std::vector<NodeSum>& filled_stripe(std::size_t index);
  /// Adds what other points say. Throws Error where `other` is of another road.
  void add(const NodeSums& other);

 private:
  static constexpr NodeSum kNothing{};
  std::size_t rows_, columns_, in_stripe_;
  std::vector<std::vector<NodeSum>> stripes_;
};

/// The sums of some of a node's points, of which others may be taken away.
struct PartSum {
  PartSum() = default;
  PartSum(const NodeSum& sum);
  double points = 0.0, height = 0.0, height2 = 0.0, range = 0.0;
};

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
NodeHeight measured(const PartSum& sum, const Noise& noise);
/// Of a node by those around it that have at least so many points and are not `wild` (as long as
/// the nodes, or empty): their plane. No height with less than four of them.
NodeHeight between_neighbours(const NodeSums& sums, std::size_t row, std::size_t column,
                              const RoadFrame& frame, float least, const Noise& noise,
                              const std::vector<std::uint8_t>& wild);

/// Of a node by the nearest such in its column before and behind it: kerbs and their edges go on
/// along the road, where a plane goes over them. No height unless both are within 1 m.
NodeHeight along_column(const NodeSums& sums, std::size_t row, std::size_t column,
                        const RoadFrame& frame, float least, const Noise& noise,
                        const std::vector<std::uint8_t>& wild);

/// What is known with the smaller variance.
NodeHeight better(const NodeHeight& a, const NodeHeight& b);

/// By its own points and by those around it, as far as there are any.
NodeHeight together(const NodeHeight& node, const NodeHeight& around);

/// Whether few points of a node are a blade's, a drop's or of a wall's foot: three deviations above
/// what those around it show.
bool is_wild(const NodeHeight& node, const NodeHeight& around);

/// Variance of grass too low to be told from a rough road, m^2.
double variance_of_grass(const Sections& sections, const RoadFrame& frame, std::size_t row,
                         double v_m);

/// Variance that a node's height has in common with its neighbours and with the base, which holds
/// the poses: what is left of the drift.
double variance_in_common(const StretchDeviation& left, const RoadFrame& frame, std::size_t row,
                          double v_m);

}  // namespace cloud
