// Where the reference line leads at a segment.
#pragma once

#include <vector>

#include "crg/reference_line.h"

namespace crg {

struct Direction {
  double heading_rad;
  double curvature_1pm;  ///< left turn positive
};

/// One per segment. Curvature from the cross product of the two chords that meet in the segment's
/// first node, each half a metre or one row long. Nearer than that to an open end the reference
/// implementation answers the heading of that end and no curvature, and so do we.
std::vector<Direction> directions_of(const ReferenceLine& line);

}  // namespace crg
