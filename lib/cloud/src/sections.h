// Scans boiled down for the estimation of drift: per 5 m driven, the mean of what each 0.25 m cell
// of the road shows. Its size depends on the distance driven, not on the number of points.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "cloud/map.h"
#include "cloud/road_frame.h"
#include "cloud/trajectory.h"

namespace cloud {

inline constexpr double kSectionLength_m = 5.0;
inline constexpr double kSectionCell_m = 0.5;
inline constexpr double kVergeStretch_m = 10.0;

/// Mean of the points of one cell, relative to the section's sensor position.
struct SectionCell {
  float x_m = 0.0f, y_m = 0.0f, z_m = 0.0f;
  float points = 0.0f;
  float driven_m = 0.0f;    ///< from the section's middle to where they were seen from
  float driven2_m2 = 0.0f;  ///< mean of its square
  float square_m2 = 0.0f;   ///< sum of squares of heights about the cell's own plane,
                            ///< with fewer than 4 points about the base's
  float freedom = 0.0f;     ///< degrees of freedom of that
  float sine2 = 0.0f;       ///< mean square of the sine of the angle of view; 0: no sensor
  bool beyond = false;      ///< beyond the verge: no word about the trajectory
};

/// What the sensor saw from one piece of its path. Corrections turn about position_m.
struct Section {
  int piece = 0;  ///< drift is continuous within a piece of the trajectory
  int pass = 0;   ///< counts laps; sections of different passes are compared
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d ahead =
      Eigen::Vector3d::Zero();  ///< where the sensor moves, per metre; zero in the map frame
  double heading_rad = 0.0;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();     ///< the sensor's ahead, left, up
  Eigen::Vector3d turning_1pm = Eigen::Vector3d::Zero();  ///< how the axes turn, rad per metre
  double row = 0.0, v_m = 0.0;                            ///< of the sensor on the road
  std::vector<SectionCell> cells;
  bool has_data() const { return !cells.empty(); }
};

/// x, y, z in map axes; roll, pitch, yaw about the sensor's axes (ahead, left, up).
using Correction = Eigen::Matrix<double, 6, 1>;

/// Rotation of a correction in map axes.
Eigen::Matrix3d rotation_of(const Correction& correction, const Eigen::Matrix3d& axes);

/// Consecutive sections of one piece are neighbours in the vector; those without data stay in,
/// empty.
struct Sections {
  std::vector<Section> list;
  std::vector<double> centre_m;  ///< along Trajectory::driven_m (map frame: along u)
  /// How much more than the road under the wheels the surface scatters, m^2, by kVergeStretch_m
  /// along and kSectionCell_m across: grass too low to be told from a rough road.
  std::vector<float> excess_m2;
  std::size_t points = 0;         ///< looked at
  std::size_t without_pose = 0;   ///< outside the trajectory's time
  std::size_t off_road = 0;       ///< beside the grid, or on a hole of it
  std::size_t far_from_base = 0;  ///< higher or lower than the gate
  std::size_t on_obstacles = 0;   ///< in cells where something stands on the road
  std::size_t on_grass = 0;       ///< beside the road, on what scatters
  double time_begin_s = 0.0, time_end_s = 0.0;
  Eigen::Vector2d min_m = Eigen::Vector2d::Constant(1e300),
                  max_m = Eigen::Vector2d::Constant(-1e300);  ///< map frame
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

/// A point on the road: place, height over the base.
struct RoadPoint {
  Eigen::Vector3d map_m;
  GridPlace place;
  double above_base_m = 0.0;
  double driven_m = 0.0;
  Eigen::Vector3d ray = Eigen::Vector3d::Zero();  ///< from the sensor, of length 1; 0 without one
  double range_m = 0.0;                           ///< from the sensor; 0 without one
  double sine2 = 0.0;  ///< of the angle between ray and road, squared; 0 without a sensor
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
};

/// First reading of the scans. `drifting`: the drift is still in the trajectory.
Sections collect_sections(const CloudSource& source, const RoadFrame& frame,
                          const RoadTrajectory* trajectory, const MapOptions& options,
                          bool drifting);

}  // namespace cloud
