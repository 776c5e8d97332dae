// Heights per node of the grid from corrected points, and their fusion with the base.
#pragma once

#include "cloud/map.h"
#include "height_cells.h"
#include "left_out.h"

namespace cloud {

/// Second reading: every point near `surface` (which has the robust heights) goes to the node next
/// to it. `trajectory` is the corrected one; null: corrections of sections along u.
RoadSums accumulate(const CloudSource& source, const RoadFrame& frame,
                    const RoadTrajectory* trajectory, const Sections& sections, const Drift& drift,
                    const HeightCells& surface, const MapOptions& options);

/// Fills grid, stddev, source and the node part of the report.
void fuse(const RoadSums& sums, const RoadFrame& frame, const crg::Grid& base,
          const Sections& sections, const Drift& drift, const MapOptions& options,
          MapResult& result);

}  // namespace cloud
