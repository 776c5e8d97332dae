// The trial of lidar2mesh: a known road, a base that is wrong in three ways, two synthetic laps.
#pragma once

#include <string>

#include "cloud/map.h"
#include "cloud/synth.h"
#include "crg/file.h"

namespace support {

/// The demo circuit with 20 mm bumps, and the same without them, with 1 degree too little banking
/// in the corner of u = 476..552 m and the kerb of u = 640..730 m 3 cm too low.
struct TrialRoads {
  crg::Crg truth, base;
};
TrialRoads trial_roads(double step_m = 0.1);

struct TrialError {
  std::size_t road_nodes = 0;  ///< covered by points, on the road itself
  double z_rmse_m = 0.0, z_p99_m = 0.0, z_max_m = 0.0;
  double base_rmse_m = 0.0;  ///< of the base, at the same nodes
  double banking_error_rad =
      0.0;                    ///< largest over the driven road, cross slope fitted over 2 m of road
  double kerb_error_m = 0.0;  ///< of the crest, largest over u = 645..725 m
  double kerb_p95_m = 0.0;    ///< the same, of 95 % of the rows
  double drift_x_m = 0.0, drift_y_m = 0.0,
         drift_z_m = 0.0;  ///< largest distance of the corrected poses from the truth
  double drift_rms_xy_m = 0.0, drift_rms_z_m = 0.0;
  double within_90 =
      0.0;  ///< share of covered nodes whose error lies within 1.645 stated deviations
  std::size_t changed_outside = 0;  ///< nodes without points whose bits are not the base's
};
TrialError measure_trial(const TrialRoads& roads, const cloud::MapResult& result,
                         const cloud::Trajectory& truth, double u_begin_m, double u_end_m);

std::string describe(const TrialError& error);

}  // namespace support
