// How far from the reference line a point may lie and still be certain to belong to the leg of the
// track beside it. Lets a query that starts from a good guess skip the global search and still
// give the answer that the global search would give.
#pragma once

#include <span>

#include "closing.h"
#include "line_geometry.h"

namespace crg {

/// Sets the certain range of every segment, the same for a run of neighbours. `segments`: those of
/// the line; `v_right_m`, `v_left_m`: the v range; `joined`: the last segment leads to the first;
/// `closing`: by how much the ends are prolonged to meet.
/// Conservative: ranges may be tighter than necessary, never wider.
/// Method: within a stretch that turns less than 0.6 rad, cells overlap only beyond the centre of
/// curvature; against everything else, a ball around the point of radius |v| must be empty (the
/// ball test of Federer's reach, with the spacing of the stations as slack).
void measure_clearance(std::span<SegmentRecord> segments, double v_right_m, double v_left_m,
                       double u_step_m, bool joined, const Closing& closing);

}  // namespace crg
