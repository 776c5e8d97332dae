// Heights per node of the grid from corrected points, and their fusion with the base.
#pragma once

#include "drift.h"
#include "height_cells.h"

namespace cloud {

/// Of the points next to a node: how many, their heights over the base and the squares of these.
struct NodeSum {
  float points = 0.0f, height = 0.0f, height2 = 0.0f;
};

/// Sums per node; row after row, one row less on a closed road (its last row is its first). Only
/// stripes of rows on which points fell take memory.
class NodeSums {
 public:
  static constexpr std::size_t kStripeRows = 64;

  NodeSums(std::size_t rows, std::size_t columns);
  explicit NodeSums(const RoadFrame& frame);
  std::size_t size() const { return rows_ * columns_; }  ///< nodes
  std::size_t columns() const { return columns_; }
  const NodeSum& operator[](std::size_t node) const {
    const std::vector<NodeSum>& stripe = stripes_[node / in_stripe_];
    return stripe.empty() ? kNothing : stripe[node % in_stripe_];
  }
  std::size_t stripes() const { return stripes_.size(); }
  /// Empty where no point fell; else kStripeRows rows, of the last stripe as many as there are.
  const std::vector<NodeSum>& stripe(std::size_t index) const { return stripes_[index]; }
  /// The same to be written; no two threads at one stripe.
  std::vector<NodeSum>& filled_stripe(std::size_t index);
  /// Adds what other points say. Throws Error where `other` is of another road.
  void add(const NodeSums& other);

  std::size_t read = 0, used = 0;  ///< points

 private:
  static constexpr NodeSum kNothing{};
  std::size_t rows_, columns_, in_stripe_;
  std::vector<std::vector<NodeSum>> stripes_;
};

/// Second reading: every point near `surface` (which has the robust heights) goes to the node next
/// to it. `trajectory` is the corrected one; null: corrections of sections along u.
NodeSums accumulate(const CloudSource& source, const RoadFrame& frame,
                    const RoadTrajectory* trajectory, const Sections& sections, const Drift& drift,
                    const HeightCells& surface, const MapOptions& options);

/// Fills grid, stddev, source and the node part of the report.
void fuse(const NodeSums& sums, const RoadFrame& frame, const crg::Grid& base,
          const Sections& sections, const Drift& drift, const MapOptions& options,
          MapResult& result);

}  // namespace cloud
