// Where the road ends to either side, row by row, and what is done with the surface beyond.
#pragma once

#include <cstddef>
#include <vector>

#include "crg/reference_line.h"
#include "road/centreline.h"
#include "road/sample.h"

namespace road {

/// v of the road's edges in every row of its grid, kerbs inside; right <= 0 <= left. Empty: nothing
/// is known, all of the grid counts as road.
struct RoadEdges {
  std::vector<double> right_m, left_m;
  bool empty() const { return left_m.empty(); }
  bool has(std::size_t row, double v_m) const {
    return empty() || (v_m >= right_m[row] && v_m <= left_m[row]);
  }
};

/// In each row the outermost node of road or kerb that follows from the line on: over what is
/// missing up to the width that was traced, further only without a break. A notch of the edge
/// belongs to the road: all of it where both ends are abrupt and no more than 12 m apart, else up
/// to the lines at 45 degrees from its ends, as far as the road is narrower there than it usually
/// is within 150 m; but not in rows that sampling cut short (`report`).
RoadEdges road_edges(const SampledGrid& sampled, const crg::ReferenceLine& line,
                     const Centreline& centreline, const SampleReport& report);

/// Whether rows [first, last] have nothing of the road between v_begin_m and v_end_m.
bool lies_beyond(const RoadEdges& edges, std::size_t first, std::size_t last, double v_begin_m,
                 double v_end_m);

/// A hole of the surface larger than this is a wheel's.
constexpr double kMaxHole_m = 0.5;

/// Beyond an edge of the road the surface ends before the first hole larger than kMaxHole_m; the
/// border leads there at 45 degrees or less. Holes that reach into the road stay. Changes
/// nodes_with_z, filled and holes of `report` and sets its cut_left and cut_right: rows whose
/// surface ends more than 1 m nearer than before and behind, at lines of 45 degrees, for whatever
/// reason.
void end_where_whole(SampledGrid& sampled, const RoadEdges& edges, const crg::ReferenceLine& line,
                     SampleReport& report);

}  // namespace road
