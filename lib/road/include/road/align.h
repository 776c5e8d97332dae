// From the mesh's frame to global coordinates.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "base/answer.h"
#include "crg/file.h"
#include "crg/reference_line.h"
#include "mesh/mesh.h"
#include "road/projection.h"

namespace road {

/// global = rotation about z by yaw_rad, then translation.
struct RotoTranslation {
  double yaw_rad = 0.0;
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();
};

struct ControlPoint {
  std::string name;
  Eigen::Vector3d mesh_m;
  Eigen::Vector3d global_m;
};

/// What a road cannot do and its mesh must: p becomes about_m + linear (p - about_m). The rotation
/// in `linear` is about a level axis; what turns about z is in the RotoTranslation that comes
/// after.
struct TiltAndScale {
  Eigen::Vector3d about_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();

  bool is_identity() const { return linear == Eigen::Matrix3d::Identity(); }
  Eigen::Vector3d operator()(const Eigen::Vector3d& p_m) const {
    return is_identity() ? p_m : Eigen::Vector3d(about_m + linear * (p_m - about_m));
  }
};

struct AlignOptions {
  enum class Rotation : std::uint8_t {
    about_z,  ///< z stays up
    free      ///< at least 3 points, none of them on the line of the others; tilts of at most 20
              ///< degrees
  } rotation = Rotation::about_z;
  bool scale = false;  ///< one factor for all axes, 0.5 to 2
  /// Points that contradict the others are named and left out; needs at least 4 points (5 for a
  /// free rotation), of which more than half agree.
  bool reject_outliers = true;
  /// Nothing nearer than this is called an outlier, however well the others agree.
  double smallest_outlier_m = 0.05;
};

struct AlignReport {
  TiltAndScale tilt_and_scale;  ///< done to the mesh first; identity unless AlignOptions asks for
                                ///< more than the other
  RotoTranslation T_global_mesh;
  std::vector<double> residual_m;     ///< per control point, outliers too
  double rms_m = 0.0;                 ///< over the points that were used
  std::vector<std::string> outliers;  ///< names of the points left out
  /// What was applied of them; otherwise what a free rotation and scale would add, as a check of
  /// units and plumb, NaN when fewer than 3 points were used or they lie on a line.
  double tilt_rad = std::numeric_limits<double>::quiet_NaN();
  double scale = std::numeric_limits<double>::quiet_NaN();
};

/// Least squares over >= 2 control points (>= 3 m apart): rotation about z and translation; free
/// rotation (>= 3 points that span a plane) and scale where the options ask for them. A refusal
/// of a degenerate set, and when no such motion fits: says whether the points are a mirror image
/// (latitude and longitude swapped, wrong hemisphere) or scaled (units).
base::Answer<AlignReport> try_fit_alignment(const std::vector<ControlPoint>& points,
                                            const AlignOptions& options = {});

/// The same for those who have no other points: throws the refusal as Error.
AlignReport fit_alignment(const std::vector<ControlPoint>& points,
                          const AlignOptions& options = {});

/// Rotation, translation and, if wanted, scale without constraint: global = scale * R * mesh + t.
struct Similarity {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();
  double scale = 1.0;
  std::vector<double> residual_m;
  double rms_m = 0.0;
};

/// Least squares (Horn 1987) over >= 3 points that span a plane. A refusal of a degenerate
/// set.
base::Answer<Similarity> fit_similarity(const std::vector<ControlPoint>& points, bool with_scale);

/// Aligns a road's middle line with a driven track (positions from GNSS, either direction, any
/// start, closed or part of a lap) without known point pairs. The result is exact as far as the
/// driver kept to the middle: what is asymmetric about the racing line remains. residual_m:
/// distance of each trajectory point from the aligned line in plan. A refusal when either has
/// less than 10 points, the two differ in shape, or the road lies on itself when it is turned.
base::Answer<AlignReport> fit_to_trajectory(const std::vector<Eigen::Vector3d>& middle_m,
                                            bool closed,
                                            const std::vector<Eigen::Vector3d>& trajectory_m);

/// Control points of a file and what geographic ones were projected with.
struct ControlPoints {
  std::vector<ControlPoint> points;
  Projection projection;  ///< none: the file has projected coordinates
  std::vector<Eigen::Vector2d>
      latitude_longitude_deg;  ///< as in the file; empty for projected ones
};

/// CSV with header [name,]mesh_x_m,mesh_y_m,mesh_z_m and either x_m,y_m,z_m or lat_deg,lon_deg,h_m
/// (WGS84; projected about the first row). Throws Error with file:line on a wrong
/// header, a missing or bad number, a latitude beyond 90 degrees.
ControlPoints read_control_point_file(const std::string& path,
                                      Projection::Kind kind = Projection::Kind::utm);

/// Positions along a driven track: CSV with lat_deg,lon_deg,h_m or x_m,y_m,z_m. Rows without a
/// number are left out (receivers lose their fix). Throws Error on a wrong header or fewer than 10
/// positions.
struct Trajectory {
  std::vector<Eigen::Vector3d> points_m;
  Projection projection;  ///< none: the file has projected coordinates
};
Trajectory read_trajectory(const std::string& path, Projection::Kind kind = Projection::Kind::utm);
/// The points alone.
std::vector<ControlPoint> read_control_points(const std::string& path);

/// Tilts and scales every vertex.
void apply_to_mesh(const TiltAndScale& tilt_and_scale, Mesh& mesh);

/// Moves the line, and with it the heights that it carries, to the global frame.
void apply_alignment(const RotoTranslation& T_global_mesh, crg::ReferenceLine& line);

}  // namespace road
