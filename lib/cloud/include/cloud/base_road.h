// A first road from nothing but points and the line that was driven, for map_clouds to refine.
#pragma once

#include "cloud/map.h"
#include "cloud/trajectory.h"
#include "crg/file.h"
#include "road/centreline.h"

namespace cloud {

struct BaseRoadOptions {
  double u_step_m = 0.1, v_step_m = 0.1;
  double v_max_m = 10.0;  ///< to both sides of the line
  double below_m = 5.0;   ///< points lower than this under the line are another road ...
  double above_m = 1.0;   ///< ... and those higher than this above it hang over the road
  unsigned threads = 0;   ///< any number gives the same bytes
};

/// The first lap of a trajectory as a line to put a road along: closed where it comes back to
/// within 10 m of where it began. Throws Error where it is shorter than 20 m.
road::Centreline driven_line(const Trajectory& trajectory);

/// Heights are the lowest points of cells of 0.5 m, less those that stick out of their
/// surroundings: right to some centimetres, holes where no points are. `trajectory` null: the
/// points are in the map frame. Throws Error where no point lies along the line.
crg::Crg base_from_points(const CloudSource& scans, const road::Centreline& line,
                          const Trajectory* trajectory, const BaseRoadOptions& options = {});

/// Refines such a road, twice where there is a trajectory: heights come from points alone, nodes
/// without points become holes. The trajectory's drift is corrected between its passes only; where
/// they lie in the map is the trajectory's word.
MapResult map_without_base(const CloudSource& scans, const crg::Crg& first,
                           const Trajectory* trajectory, MapOptions options);

}  // namespace cloud
