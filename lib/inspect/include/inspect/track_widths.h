// Line and widths of a road, as programs for racing lines read them:
// x_m,y_m,w_tr_right_m,w_tr_left_m.
#pragma once

#include <string>
#include <vector>

#include "crg/grid.h"
#include "crg/reference_line.h"
#include "road/road_edges.h"

namespace road {

/// One node of the reference line, map coordinates, and how far the road goes to either side.
struct TrackWidth {
  double x_m = 0.0, y_m = 0.0;
  double right_m = 0.0, left_m = 0.0;      ///< >= 0, along the mitre normal of crg::node_position
  double right_v_m = 0.0, left_v_m = 0.0;  ///< the same as v: <= 0 and >= 0
};

/// One entry per row of the grid, without the last of a closed line where it repeats the first. The
/// road ends at the last column before the first NaN outwards from v = 0, so a width is short of
/// the true edge by less than a column; or nearer, at `edges` (v, one row each), where given.
/// Throws Error with u where the line has no road on it or the
/// columns do not reach over v = 0, or where line and grid do not fit each other.
std::vector<TrackWidth> track_widths(const crg::ReferenceLine& line, const crg::Grid& grid,
                                     const RoadEdges& edges = {});

/// CSV whose header line begins with '#'; 0.1 mm. Heights have no place in it.
std::string track_widths_csv(const std::vector<TrackWidth>& widths);

}  // namespace road
