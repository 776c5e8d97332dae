// How far from the reference line a point may lie and still be certain to belong to the leg of the
// track beside it. Lets a query that starts from a good guess skip the global search and still
// give the answer that the global search would give.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "line_geometry.h"

namespace crg {

/// Bounds per station (a run of 2^shift segments): a point whose cell is in the run and whose v
/// lies in [right_m, left_m] has no other cell with an equal or smaller |v|, and lies within the v
/// range of the road. Empty (right > left) where nothing is certain.
struct Clearance {
  struct Bound {
    float right_m = 1.0F;
    float left_m = -1.0F;
  };
  std::uint32_t shift = 0;
  std::vector<Bound> bounds;

  bool covers(std::size_t segment, double v_m) const {
    const Bound& bound = bounds[segment >> shift];
    return v_m <= static_cast<double>(bound.left_m) && v_m >= static_cast<double>(bound.right_m);
  }
};

/// `frames`: the segments of the line; `v_right_m`, `v_left_m`: the v range; `joined`: the last
/// segment leads to the first. Conservative: bounds may be tighter than necessary, never wider.
/// Method: within a stretch that turns less than 0.6 rad, cells overlap only beyond the centre of
/// curvature; against everything else, a ball around the point of radius |v| must be empty (the
/// ball test of Federer's reach, with the spacing of the stations as slack).
Clearance measure_clearance(const std::vector<SegmentFrame>& frames, double v_right_m, double v_left_m, double u_step_m, bool joined);

}  // namespace crg
