// Where a map point lies on the road: (x, y) -> cell of the reference line and place in it.
#pragma once

#include <cstddef>
#include <vector>

#include "clearance.h"
#include "closing.h"
#include "line_geometry.h"

namespace crg {

/// A segment and what height needs of it, in one cache line.
struct alignas(64) SegmentRecord {
  SegmentFrame frame;
  double z_m = 0.0;  ///< height of the reference line at the first node
};

/// Place of a point. fraction is 0 at the first node of the segment, 1 at the second; below 0 or
/// above 1 only before the first and behind the last segment, where beyond_m tells how far (< 0,
/// > 0).
struct Place {
  std::size_t segment = 0;
  double fraction = 0.0;
  double v_m = 0.0;
  double beyond_m = 0.0;
};

/// Of all cells that hold the point, the one where it is least outside [v_right, v_left], then the
/// one with the smallest |v|, then the first. Cell i holds a point that lies on or behind mitre
/// line i and before mitre line i + 1. The extensions before the start and behind the end count as
/// outside by their length. Every finite point has a place.
class Locator {
 public:
  Locator() = default;
  Locator(const ReferenceLine& line, double v_right_m, double v_left_m);

  /// `hint`: any segment; a good one is fast, the answer is the same for all.
  Place locate(double x_m, double y_m, std::size_t hint) const noexcept;

  const SegmentRecord* records() const { return records_.data(); }
  std::size_t segments() const { return records_.size() - 1; }

 private:
  struct Box {
    double x_min_m, x_max_m, y_min_m, y_max_m;
    double stretch;
  };
  struct Best;

  bool locate_near(double x_m, double y_m, std::size_t hint, Place& place) const noexcept;
  Place search(double x_m, double y_m) const noexcept;
  void search_leaf(std::size_t leaf, double x_m, double y_m, Best& best) const noexcept;
  void search_ends(double x_m, double y_m, Best& best) const noexcept;
  double outside(double v_m) const noexcept;

  std::vector<SegmentRecord> records_;  ///< one per segment, and one for the last node
  Clearance clearance_;
  std::vector<Box> boxes_;  ///< binary tree, children of k at 2k + 1 and 2k + 2
  std::size_t first_leaf_ = 0;
  double v_right_m_ = 0.0, v_left_m_ = 0.0, reach_m_ = 0.0;
  bool joined_ = false;
  Closing closing_;
};

}  // namespace crg
