// The curves of the report: what the road is like along u. Private to the report.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "inspect/compare.h"
#include "inspect/height_map.h"
#include "report/track_report.h"

namespace road {

/// What the road was compared with, under the report's keys: mesh, against, cloud, before.
using Comparisons = std::vector<std::pair<std::string, Comparison>>;

/// One value per row of the map; NaN where the row has no heights. Headings go on beyond a turn.
struct AlongU {
  std::vector<float> elevation_m, slope, vertical_curvature_1pm, banking, heading_rad,
      curvature_1pm, curvature_rate_1pm2, width_m, v_left_m, v_right_m;
};

AlongU along_u(const HeightMap& map, const std::vector<RowExtent>& extents);

/// All of it, and the largest error of each row, thinned to what a page can draw.
void add_curves(const HeightMap& map, const AlongU& along, const Comparisons& comparisons,
                report::TrackReport& report);

}  // namespace road
