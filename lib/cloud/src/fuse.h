// Heights per node of the grid from corrected points, and their fusion with the base.
#pragma once

#include "drift.h"
#include "height_cells.h"

namespace cloud {

/// Sums of heights over the base per node; row after row, one row less on a closed road (its last
/// row is its first).
struct NodeSums {
  std::vector<float> points, height, height2;
};

/// Second reading: every point near `surface` (which has the robust heights) goes to the node next
/// to it. `trajectory` is the corrected one; null: corrections of sections along u.
NodeSums accumulate(const CloudSource& source, const RoadFrame& frame,
                    const RoadTrajectory* trajectory, const Sections& sections, const Drift& drift,
                    const HeightCells& surface, const MapOptions& options, MapReport& report);

/// Fills grid, stddev, source and the node part of the report.
void fuse(const NodeSums& sums, const RoadFrame& frame, const crg::Grid& base,
          const Sections& sections, const Drift& drift, const MapOptions& options,
          MapResult& result);

}  // namespace cloud
