// Scans boiled down for the estimation of drift: per 5 m driven, the mean of what each 0.25 m cell
// of the road shows. Its size depends on the distance driven, not on the number of points.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <vector>

#include "cloud/map_options.h"
#include "cloud/read_cloud.h"
#include "road_trajectory.h"
#include "standing.h"

namespace cloud {

inline constexpr double kSectionLength_m = 5.0;
inline constexpr double kVergeStretch_m = 10.0;
inline constexpr double kLane_m = 1.2;  ///< to both sides of the sensor: what the wheels roll on

/// What stands upright along the road, as a wall does: where across it, and how far its points
/// deviate from that; 0: none.
struct Sheet {
  float v_m = 0.0f, deviation_m = 0.0f;
};

/// Mean of the points of one cell, relative to the section's sensor position.
struct SectionCell {
  float x_m = 0.0f, y_m = 0.0f, z_m = 0.0f;
  float points = 0.0f;
  float driven_m = 0.0f;     ///< from the section's middle to where they were seen from
  float driven2_m2 = 0.0f;   ///< mean of its square
  float square_m2 = 0.0f;    ///< sum of squares of heights about the cell's own plane,
                             ///< with fewer than 4 points about the base's
  float freedom = 0.0f;      ///< degrees of freedom of that
  float sine2 = 0.0f;        ///< mean square of the sine of the angle of view; 0: no sensor
  float cut_above_m = 0.0f;  ///< points more than this over the ground were left out; 0: none were
  float cut_points = 0.0f;   ///< that many
  Sheet sheet = {};          ///< in it
  bool doubtful = false;     ///< near grass, and not all on a ground of their own
  bool beyond = false;       ///< beyond the verge: no word about the trajectory
  bool beside = false;       ///< nor near what stands: its foot is in the ground that is left
  bool apart = false;        ///< nor where passes differ: the ground changed between them
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
  std::vector<std::size_t> first_of_piece;
  /// How much more than the road under the wheels the surface scatters, m^2, by kVergeStretch_m
  /// along and kSectionCell_m across: grass too low to be told from a rough road.
  std::vector<float> excess_m2;
  /// By the same: grass. What the drift's correction moves onto it is no ground.
  std::vector<std::uint8_t> grass;
  std::size_t points = 0;         ///< looked at
  std::size_t without_pose = 0;   ///< outside the trajectory's time
  std::size_t off_road = 0;       ///< beside the grid, or on a hole of it
  std::size_t far_from_base = 0;  ///< higher or lower than the gate
  std::size_t on_obstacles = 0;   ///< in cells where something stands on the road
  std::size_t on_grass = 0;       ///< beside the road, on what scatters
  double time_begin_s = std::numeric_limits<double>::infinity(), time_end_s = -time_begin_s;
  Eigen::Vector2d min_m = Eigen::Vector2d::Constant(1e300),
                  max_m = Eigen::Vector2d::Constant(-1e300);  ///< map frame

  /// The section of a piece in which something was driven.
  std::size_t index_at(int piece, double driven_m) const;
};

/// Number of the column of kVergeStretch_m by kSectionCell_m that holds a place of the road.
std::size_t verge_column(const RoadFrame& frame, double row, double v_m);

/// Sections along the trajectory (or along u), with nothing in them yet.
Sections empty_sections(const RoadFrame& frame, const RoadTrajectory* trajectory);

/// What a reading of the scans, or of a part of them, shows, before anything is judged that needs
/// all of them.
struct Look {
  Sections sections;
  Standing standing;
};

/// Reads the scans. `trajectory` null: the points are in the map frame. `visits_known`: the points'
/// classes are the numbers of their visits (visits.h) among all points, of which these are a part.
Look look_at(const CloudSource& source, const RoadFrame& frame, const RoadTrajectory* trajectory,
             const MapOptions& options, bool visits_known = false);

/// Adds what another part of the scans shows. No section may have cells in both: throws Error.
void join(Look& all, Look&& part);

/// Leaves out feet of walls and the verge. `drifting`: the drift is still in the trajectory.
/// `edge_m`: |v| up to which nothing is grass.
Sections judged(Look&& look, const RoadFrame& frame, bool drifting, double edge_m);

}  // namespace cloud
