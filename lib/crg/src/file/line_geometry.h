// The cell between two nodes of the reference line: a straight segment between two mitre lines.
#pragma once

#include <cstddef>

#include "crg/reference_line.h"
#include "two.h"

namespace crg {

/// One segment with the mitre lines at its ends. s runs along it from its first node, v is the
/// perpendicular offset to the left. The mitre line at the beginning runs through
/// (s, v) = (v * begin_lean, v), the one at the end through (length_m + v * end_lean(), v).
struct SegmentFrame {
  double x_m = 0.0, y_m = 0.0;
  double cos = 1.0, sin = 0.0;
  double length_m = 0.0;
  double begin_lean = 0.0;
  double lean_change = 0.0;  ///< from the beginning to the end

  /// s of the point a fraction of the way from one mitre line to the other.
  double along(double fraction, double v_m) const {
    return v_m * begin_lean + fraction * width(v_m);
  }
  /// Distance between the mitre lines at v; not positive beyond the centre of curvature.
  double width(double v_m) const { return length_m + v_m * lean_change; }
  double end_lean() const { return begin_lean + lean_change; }
  Point2 point(double s_m, double v_m) const {
    return {x_m + s_m * cos - v_m * sin, y_m + s_m * sin + v_m * cos};
  }
};

SegmentFrame segment_frame(const ReferenceLine& line, std::size_t row);
/// The same where the directions of both its mitre lines are known.
SegmentFrame segment_frame(const ReferenceLine& line, std::size_t row, const Point2& begin_mitre,
                           const Point2& end_mitre);

/// What finding a place needs of a segment, in one cache line. A point whose cell is this one and
/// whose v lies in [certain_right_m, certain_left_m] has no other cell with an equal or smaller
/// |v|, and lies within the v range of the road (clearance.h). Empty (right > left) where nothing
/// is certain.
struct alignas(64) SegmentRecord {
  SegmentFrame frame;
  float certain_right_m = 1.0F;
  float certain_left_m = -1.0F;

  bool certain(double v_m) const {
    return v_m <= static_cast<double>(certain_left_m) &&
           v_m >= static_cast<double>(certain_right_m);
  }
  /// The same with one test for both, but not for certain_left_m itself.
  bool surely_certain(double v_m) const { return signs(both(v_m) - two_at(&certain_right_m)) == 2; }
};

/// Unit vector that the mitre line at `row` is perpendicular to.
Point2 mitre_direction(const ReferenceLine& line, std::size_t row);

/// Whether the last node of a closed line lies on the first (nearer than half a step): then both
/// share one mitre line.
bool ends_joined(const ReferenceLine& line);

}  // namespace crg
