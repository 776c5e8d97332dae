// Where the reference line leads at a segment.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "line_geometry.h"

namespace crg {

struct Direction {
  double heading_rad;
  double curvature_1pm;  ///< left turn positive
};

/// How many segments half a metre is, at least one: so long are the chords.
std::size_t chord_segments(double u_step_m);
/// Whether every row has both its chords: on a line whose last row repeats the first, if it is long
/// enough.
bool chords_go_around(std::size_t rows, double u_step_m, bool joined);

/// One per segment. `nodes`: a record for every row, of which only the position is used;
/// `heading_rad`: as in ReferenceLine; `joined`: the last row repeats the first. Curvature from the
/// cross product of the two chords that meet in the segment's first node, each half a metre or one
/// row long. Nearer than that to an open end the reference implementation answers the heading of
/// that end and no curvature, and so do we.
std::vector<Direction> directions_of(std::span<const SegmentRecord> nodes,
                                     std::span<const double> heading_rad, double u_step_m,
                                     bool joined);

}  // namespace crg
