// A trajectory on the road, and the points that were measured from it.
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <string>
#include <vector>

#include "cloud/cloud.h"
#include "cloud/error.h"
#include "cloud/road_frame.h"
#include "cloud/trajectory.h"

namespace cloud {

/// The scans do not fit the base.
struct Misfit : Error {
  using Error::Error;
};

/// The trajectory with the places of its poses on the road.
struct RoadTrajectory {
  Trajectory poses;
  std::vector<double> row, v_m;
  std::vector<int> pass;
};

/// Rows by walking along the road; a pass ends where the sensor comes round again. Throws
/// Error where most poses lie beside the road (says where both are).
RoadTrajectory place_on_road(Trajectory trajectory, const RoadFrame& frame);

/// Poses so far apart that the way between them is not known to 2 cm, in words; empty: they are
/// not.
std::string about_rate(const Trajectory& poses);

/// A point on the road: place, height over the base.
struct RoadPoint {
  Eigen::Vector3d map_m;
  GridPlace place;
  double above_base_m = 0.0;
  double driven_m = 0.0;
  Eigen::Vector3d ray_m = Eigen::Vector3d::Zero();  ///< from the sensor; 0 without one
  std::size_t pose = 0;
};
enum class Placed { on_road, no_pose, off_road };

/// Places points of a chunk; keeps where it was for the next one.
class Placer {
 public:
  /// `trajectory` null: the points are in the map frame.
  Placer(const RoadFrame& frame, const RoadTrajectory* trajectory)
      : frame_(frame), trajectory_(trajectory) {}
  Placed operator()(const Cloud& chunk, std::size_t i, RoadPoint& point);

 private:
  const RoadFrame& frame_;
  const RoadTrajectory* trajectory_;
  std::size_t pose_ = 0;
  double row_ = -1.0;
  double time_s_ = std::numeric_limits<double>::quiet_NaN();  ///< of the instant
  bool posed_ = false;
  PosedInstant instant_;
};

}  // namespace cloud
