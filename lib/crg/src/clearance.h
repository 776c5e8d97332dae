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
/// lies in [-right_m, left_m] has no other cell with an equal or smaller |v|.
struct Clearance {
  struct Bound {
    float left_m = 0.0F;
    float right_m = 0.0F;
  };
  std::uint32_t shift = 0;
  std::vector<Bound> bounds;

  bool covers(std::size_t segment, double v_m) const {
    const Bound& bound = bounds[segment >> shift];
    return v_m <= bound.left_m && v_m >= -bound.right_m;
  }
};

/// `frames`: the segments of the line; `reach_m`: largest |v| of interest; `joined`: the last
/// segment leads to the first. Conservative: bounds may be smaller than necessary, down to
/// nothing, never larger.
/// Method: within a stretch that turns less than 0.6 rad, cells overlap only beyond the centre of
/// curvature; against everything else, a ball around the point of radius |v| must be empty (the
/// ball test of Federer's reach, with the spacing of the stations as slack).
Clearance measure_clearance(const std::vector<SegmentFrame>& frames, double reach_m, double u_step_m, bool joined);

}  // namespace crg
