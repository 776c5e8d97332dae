// Where a map point lies on the road: (x, y) -> cell of the reference line and place in it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "clearance.h"
#include "closing.h"
#include "coarse_index.h"
#include "crg/surface.h"
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

  /// Starts from the cursor and moves it; a good cursor is fast, the answer is the same for all.
  Place locate(double x_m, double y_m, Cursor& cursor) const noexcept {
    Place place;
    if (!locate_ahead(x_m, y_m, cursor, place)) [[unlikely]] place = locate_from(x_m, y_m, cursor);
    return place;
  }
  /// The common case: the cell predicted from the last step of the cursor certainly holds the
  /// point, which then lies within the v range. Otherwise false, and nothing is changed.
  bool locate_ahead(double x_m, double y_m, Cursor& cursor, Place& place) const noexcept;
  Place locate_from(double x_m, double y_m, Cursor& cursor) const noexcept;

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
  CoarseIndex coarse_;
  std::vector<Box> boxes_;  ///< binary tree, children of k at 2k + 1 and 2k + 2
  std::size_t first_leaf_ = 0;
  double v_right_m_ = 0.0, v_left_m_ = 0.0, reach_m_ = 0.0;
  bool joined_ = false;
  Closing closing_;
};

/// A point in the frame of a segment.
struct Local {
  double s_m, v_m;
  double past_begin_m;  ///< > 0 behind the mitre line at the segment's first node

  Local(const SegmentFrame& frame, double x_m, double y_m) {
    const double dx = x_m - frame.x_m, dy = y_m - frame.y_m;
    s_m = dx * frame.cos + dy * frame.sin;
    v_m = dy * frame.cos - dx * frame.sin;
    past_begin_m = s_m - v_m * frame.begin_lean;
  }
};

inline constexpr double kNearMitre = 1e-6;  // fraction of a cell: nearer than that both sides are asked

inline std::size_t predicted_segment(const Cursor& cursor, double& steps) noexcept {
  // Floor by integer conversion: without SSE4.1 std::floor is a library call.
  constexpr double kBias = 1048576.0;
  const double ahead = std::min(std::max(cursor.fraction + cursor.advance, -1e6), 1e6);
  const auto whole = static_cast<std::ptrdiff_t>(ahead + kBias) - static_cast<std::ptrdiff_t>(kBias);
  steps = static_cast<double>(whole);
  return cursor.segment + static_cast<std::size_t>(whole);
}

inline bool Locator::locate_ahead(double x_m, double y_m, Cursor& cursor, Place& place) const noexcept {
  double steps;
  const std::size_t i = predicted_segment(cursor, steps);
  if (i >= records_.size() - 1) [[unlikely]] return false;
  const SegmentFrame& frame = records_[i].frame;
  const Local local(frame, x_m, y_m);
  const double fraction = local.past_begin_m / frame.width(local.v_m);
  // What is certain lies where the cell is not folded, so the width is positive. NaN fails too.
  if (!(fraction >= 0.0 && fraction < 1.0 - kNearMitre && clearance_.covers(i, local.v_m))) [[unlikely]] return false;
  cursor.advance = steps + (fraction - cursor.fraction);
  cursor.segment = i;
  cursor.fraction = fraction;
  place.segment = i;
  place.fraction = fraction;
  place.v_m = local.v_m;
  place.beyond_m = 0.0;
  return true;
}

}  // namespace crg
