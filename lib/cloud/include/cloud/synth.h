// Scans of a spinning LiDAR on a car driving a known road, for tests and demos.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/progress.h"
#include "cloud/trajectory.h"
#include "crg/file.h"

namespace cloud {

struct ScanSynthOptions {
  int laps = 2;
  double u_begin_m = 0.0,
         u_end_m = 0.0;  ///< part of the road that is driven; u_end_m 0: to its end
  std::vector<double> v_m = {-1.5, 1.5};  ///< lateral place of each lap, used in turn
  double speed_mps = 20.0;
  int beams = 64;       ///< evenly from -25 to -2.5 degrees
  int azimuths = 1024;  ///< shots of each beam per turn
  double turns_per_s = 10.0;
  double sensor_height_m = 1.8;
  double range_max_m = 30.0;
  double range_noise_m = 0.005;         ///< standard deviation
  double beam_divergence_rad = 0.0015;  ///< full angle; ranges are means over the footprint
  double drift_m_per_100m = 0.05;       ///< rms change of x, y and z over 100 m driven
  double drift_rad_per_100m = 0.002;    ///< the same of roll, pitch and yaw
  double drift_smooth_m = 50.0;         ///< the drift's slope is averaged over this length
  int cars = 2;                  ///< others that drive in front and behind: the first two 6 to 14 m
                                 ///< away, each further pair 9 m farther
  double grass_height_m = 0.0;   ///< blades up to this high beyond grass_from_m
  double grass_from_m = 8.0;     ///< |v| where grass begins
  double scenery_every_m = 0.0;  ///< a tree, pole or wall on each side every so many metres, 1 to
                                 ///< 3.5 m beyond grass_from_m; 0: none
  std::uint64_t seed = 1;
  std::size_t points_per_file = 2'000'000;
  unsigned threads = 0;  ///< any number gives the same bytes
  base::Progress progress;
};

struct ScanSynthReport {
  std::vector<std::string>
      scan_paths;               ///< DIR/scan_000.ply ...: sensor frame, float32, time per point
  std::string trajectory_path;  ///< DIR/trajectory.csv: with drift, as a car would state it
  std::string truth_path;       ///< DIR/truth_trajectory.csv: without
  std::size_t points = 0;
  double share_on_cars = 0.0, share_on_scenery = 0.0;
};

/// Heights come from the road's grid by bilinear interpolation. Files appear whole or not at all.
/// Throws Error (options out of range, disk), crg::Error.
ScanSynthReport synth_scans(const crg::Crg& road, const std::string& output_dir,
                            const ScanSynthOptions& options = {});

}  // namespace cloud
