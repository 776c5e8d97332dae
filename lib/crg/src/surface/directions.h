// Where the reference line leads at a segment.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "line_geometry.h"

namespace crg {

/// The headings of a line's rows as the queries answer them: of a segment the one at its second
/// node. What the ends of an open line say differently is kept beside them.
struct Headings {
  std::vector<double> of_row_rad;
  std::vector<double> first_rad, last_rad;  ///< of the first rows and the last ones, as they were

  double of_segment_rad(std::size_t segment) const { return of_row_rad[segment + 1]; }
  /// As the line has them.
  std::vector<double> of_line_rad() const;
};

/// `of_row_rad`: as in ReferenceLine. Nearer to an open end than the chords below are long the
/// reference implementation answers the heading of that end and no curvature, and so do we.
Headings headings_of(std::vector<double> of_row_rad, double u_step_m, bool joined);

/// One per segment, left turn positive, in 1/m. `nodes`: a record for every row, of which only the
/// position is used; `joined`: the last row repeats the first. From the cross product of the two
/// chords that meet in the segment's first node, each half a metre or one row long.
std::vector<double> curvatures_of(std::span<const SegmentRecord> nodes, double u_step_m,
                                  bool joined);

}  // namespace crg
