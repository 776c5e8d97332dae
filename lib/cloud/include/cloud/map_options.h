// What a map is told, and what it says of itself.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "base/progress.h"

namespace cloud {

struct MapOptions {
  double base_stddev_m = 0.02;     ///< of the base's heights where the points do not contradict it
  double drift_m_per_100m = 0.05;  ///< how fast the trajectory's x, y, z may change their error
  double drift_rad_per_100m = 0.002;  ///< the same of roll, pitch, yaw
  double gate_m = 0.5;                ///< points farther from the base than this are no road
  double edge_m = 0.0;     ///< |v| up to which nothing is grass; infinite: nowhere is any
  int estimate_every = 2;  ///< points looked at for the drift: one in so many
  bool correct_drift = true;
  bool trust_base =
      true;  ///< false: the base's heights do not hold the drift, only other passes do
  bool keep_older = false;  ///< ground that changed between passes is kept as it was, too: the
                            ///< passes are of campaigns, and a change is no fault
  int min_points = 1;       ///< of a node that takes part in the fusion
  double blend_m = 1.0;  ///< beside nodes with points the base runs into them over this width, or
                         ///< over more, for ramps of 1 %
  unsigned threads = 0;  ///< 0 = all cores; any number gives the same bytes
  base::Progress progress;
  std::function<void()> on_chunk;  ///< called by the caller's thread for every chunk of scans; what
                                   ///< it throws ends the map
};

/// One station of the drift along the trajectory.
struct DriftStation {
  int piece = 0, pass = 0;
  double driven_m = 0.0, u_m = 0.0;
  std::array<double, 6> correction{};  ///< x, y, z (m), roll, pitch, yaw (rad): added to the poses
  std::array<double, 6> stddev{};      ///< posterior; the prior's where the data says nothing
  double base_believed = 0.0;          ///< share of the cells in view whose base is believed
};

/// Ground that a pass shows at another height than those behind it.
struct ChangedPlace {
  int pass = 0;  ///< the last that shows the old ground
  double u_begin_m = 0.0, u_end_m = 0.0, v_begin_m = 0.0, v_end_m = 0.0;
  double area_m2 = 0.0, change_m = 0.0;  ///< new less old, median
};

struct MapReport {
  std::size_t points = 0, looked_at = 0, without_pose = 0, off_road = 0, far_from_base = 0,
              on_obstacles = 0, on_grass = 0, used = 0;
  bool converged =
      false;  ///< the drift changed by less than 0.2 mm and 0.02 mrad in the last round
  int iterations = 0;
  double last_move_m = 0.0;  ///< of the heights of poses, in the last of these
  std::size_t sections = 0, passes = 0;
  double rms_before_m = 0.0, rms_after_m = 0.0;  ///< robust, of cells against the base
  double pass_rms_before_m = 0.0,
         pass_rms_after_m = 0.0;                   ///< cells seen in two passes; 0 with one pass
  double inlier_share = 0.0;                       ///< cells whose base is believed
  double base_stddev_m = 0.0;                      ///< of those, found
  double base_tilt = 0.0, base_tilt_stddev = 0.0;  ///< cross slope that the whole base lacks
  double base_crown = 0.0;          ///< what it lacks in rise to both sides of its line, m/m
  double view_stddev_factor = 1.0;  ///< scatter of a cell's views over what was assumed
  double base_together = 1.0, view_together = 1.0;  ///< cells whose errors come as one
  /// One pass of each stretch against the others: nodes, and the share in the 90 % intervals that
  /// their own scatter gives; that is multiplied by the factor for 90 % to be.
  std::size_t left_out_nodes = 0;
  double left_out_within_90 = 0.0, noise_factor = 1.0;
  std::array<double, 6> typical_stddev{};  ///< median over stations: x, y, z, roll, pitch, yaw
  std::vector<std::string> unfixed;        ///< directions that the data leaves open
  std::vector<DriftStation> drift;
  std::size_t nodes = 0, nodes_lidar = 0, nodes_interpolated = 0, nodes_base = 0, nodes_hole = 0,
              nodes_blended = 0;
  double coverage = 0.0;  ///< nodes from points over nodes with road
  double changed_p50_m = 0.0, changed_p99_m = 0.0,
         changed_max_m = 0.0;  ///< |refined - base| of covered nodes
  double seconds_estimate = 0.0, seconds_drift = 0.0, seconds_grid = 0.0, seconds_fuse = 0.0;
  double seconds_read = 0.0;          ///< beside the others' work, with more than one thread
  std::vector<ChangedPlace> changed;  ///< the largest first
  std::vector<std::string> remarks;
  std::vector<std::string> faults;  ///< why the road must not be used, and what was tried
};

}  // namespace cloud
