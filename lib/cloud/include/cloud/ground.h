// Which points of an airborne or mobile cloud are ground.
#pragma once

#include <cstdint>
#include <vector>

#include "base/progress.h"
#include "cloud/cloud.h"

namespace cloud {

struct GroundOptions {
  double cell_m = 1.0;         ///< of the surface of lowest points
  double max_window_m = 18.0;  ///< radius of the largest object that is taken off (half a building)
  double slope = 0.15;         ///< steepest ground that is kept, m/m
  double height_m = 0.5;       ///< how far above the surface a point may lie ...
  double height_per_slope_m = 1.25;  ///< ... and how much more per m/m of its slope
  base::Progress progress;
};

/// 1 for ground, 0 for everything else, one per point. Progressive morphological filter: Pingel,
/// Clarke, McBride 2013, "An improved simple morphological filter for the terrain classification of
/// airborne LIDAR data". Points that lie below their surroundings by more than 5 m (multipath) are
/// no ground either; points with no other within four of the largest windows are. Work and memory
/// grow with the points, not with the area: gaps wider than four windows are left out. Throws
/// Error when the points would need more than 50 million cells (says which cell to give), or
/// when most of them are alone.
std::vector<std::uint8_t> classify_ground(const Cloud& cloud, const GroundOptions& options = {});

}  // namespace cloud
