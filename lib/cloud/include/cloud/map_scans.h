// Scans as they were given: files, the frame of their points, their unit.
#pragma once

#include <Eigen/Geometry>
#include <atomic>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/progress.h"
#include "cloud/map.h"
#include "cloud/refine.h"

namespace cloud {

/// x, y, z, roll, pitch, yaw of the sensor in the frame of the poses.
Eigen::Isometry3d sensor_in_poses(const std::vector<double>& extrinsic);

/// "m", "ft", "us-ft", "cm", "mm" or empty (automatic) as metres.
std::optional<double> metres_per_unit(const std::string& unit);

/// Where the points of the scans lie: true for the map frame, false for that of the sensor. Throws
/// Error where other options do not go with it.
bool points_lie_in_map(const RefineRequest& request);

/// Every cloud of the scans, folder after folder.
std::vector<std::string> scan_files(const RefineRequest& request);

/// The scans of a request, read as often as a stage wants them. Tells how far the whole way is:
/// within a stage that reads them, the share of it follows their bytes.
class MapScans {
 public:
  MapScans(const RefineRequest& request, std::vector<std::string> files, base::Progress progress);
  MapScans(const MapScans&) = delete;
  MapScans& operator=(const MapScans&) = delete;
  /// Points farther from the sensor than --max-range-m are left out. Valid as long as this is.
  CloudSource source();
  /// Readings from now on belong to this stage, which lies between these shares of the whole way.
  void enter(const std::string& stage, double begin_share, double end_share);
  /// Tells how far a reading is that runs in another thread. Of the thread that made this: progress
  /// is told by no other.
  void tell() const;
  /// What was seen at the last reading, with the file's name.
  const std::vector<std::string>& remarks() const { return remarks_; }

 private:
  void read(const ChunkSink& sink);
  void show(double share_of_file);

  const RefineRequest& request_;
  std::vector<std::string> files_;
  base::Progress progress_;
  CloudReadOptions options_;
  std::string stage_;
  double stage_begin_ = 0.0, stage_end_ = 0.0;
  double bytes_in_all_ = 0.0, bytes_before_ = 0.0, bytes_here_ = 0.0;
  std::vector<std::string> remarks_;
  std::thread::id owner_ = std::this_thread::get_id();
  std::atomic<double> read_share_ = 0.0;  ///< of the bytes, in this reading
};

}  // namespace cloud
