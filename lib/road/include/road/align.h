// From the mesh's frame to global coordinates by a roto-translation.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "crg/reference_line.h"

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

struct AlignReport {
  RotoTranslation T_global_mesh;
  std::vector<double> residual_m;   ///< per control point
  double rms_m = 0.0;
};

/// Least squares over >= 2 control points (>= 3 m apart). Throws Error on a degenerate set.
AlignReport fit_alignment(const std::vector<ControlPoint>& points);

/// CSV with header mesh_x_m,mesh_y_m,mesh_z_m,x_m,y_m,z_m. Throws Error with file:line.
std::vector<ControlPoint> read_control_points(const std::string& path);

/// Moves the line, and with it the heights that it carries, to the global frame.
void apply_alignment(const RotoTranslation& T_global_mesh, crg::ReferenceLine& line);

}  // namespace road
