#include "road/align.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "road/csv.h"
#include "road/error.h"

namespace road {

AlignReport fit_alignment(const std::vector<ControlPoint>& points) {
  constexpr double kSmallestSpread_m = 3.0;
  if (points.size() < 2) throw Error(fmt::format("{} control points; an alignment needs at least 2", points.size()));
  Eigen::Vector3d mesh_mean = Eigen::Vector3d::Zero(), global_mean = Eigen::Vector3d::Zero();
  for (const ControlPoint& p : points) {
    mesh_mean += p.mesh_m / static_cast<double>(points.size());
    global_mean += p.global_m / static_cast<double>(points.size());
  }
  // Rotation about z by least squares (Umeyama 1991, planar case without scale): the angle that turns
  // the summed cross and dot products of the centred points into one another.
  double cross = 0.0, dot = 0.0, spread_m = 0.0;
  for (const ControlPoint& p : points) {
    const Eigen::Vector2d a = (p.mesh_m - mesh_mean).head<2>(), b = (p.global_m - global_mean).head<2>();
    cross += a.x() * b.y() - a.y() * b.x();
    dot += a.dot(b);
    spread_m = std::max(spread_m, 2.0 * a.norm());
  }
  if (!(spread_m >= kSmallestSpread_m)) {
    throw Error(fmt::format("the control points lie within {:.2f} m of each other; wanted at least {} m so that they fix a rotation",
                            spread_m, kSmallestSpread_m));
  }
  AlignReport report;
  report.T_global_mesh.yaw_rad = std::atan2(cross, dot);
  const Eigen::AngleAxisd rotation(report.T_global_mesh.yaw_rad, Eigen::Vector3d::UnitZ());
  report.T_global_mesh.translation_m = global_mean - rotation * mesh_mean;
  double sum = 0.0;
  for (const ControlPoint& p : points) {
    report.residual_m.push_back((rotation * p.mesh_m + report.T_global_mesh.translation_m - p.global_m).norm());
    sum += report.residual_m.back() * report.residual_m.back();
  }
  report.rms_m = std::sqrt(sum / static_cast<double>(points.size()));
  return report;
}

std::vector<ControlPoint> read_control_points(const std::string& path) {
  const CsvTable table = read_csv(path, {"mesh_x_m", "mesh_y_m", "mesh_z_m", "x_m", "y_m", "z_m"});
  std::vector<ControlPoint> points;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    ControlPoint p;
    p.name = fmt::format("point {}", i + 1);
    p.mesh_m = {table.value(i, 0), table.value(i, 1), table.value(i, 2)};
    p.global_m = {table.value(i, 3), table.value(i, 4), table.value(i, 5)};
    if (!p.mesh_m.allFinite() || !p.global_m.allFinite()) {
      throw Error(fmt::format("{}: row {} has an empty cell; a control point needs all six coordinates", path, i + 1));
    }
    points.push_back(std::move(p));
  }
  return points;
}

void apply_alignment(const RotoTranslation& T_global_mesh, crg::ReferenceLine& line) {
  const double cosine = std::cos(T_global_mesh.yaw_rad), sine = std::sin(T_global_mesh.yaw_rad);
  const Eigen::Vector3d& shift = T_global_mesh.translation_m;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const double x = line.x_m[i], y = line.y_m[i];
    line.x_m[i] = cosine * x - sine * y + shift.x();
    line.y_m[i] = sine * x + cosine * y + shift.y();
    line.heading_rad[i] += T_global_mesh.yaw_rad;
  }
  // Height moves with the line, in double: added to the grid it would cost float32 its last digits.
  if (line.z_m.empty()) line.z_m.assign(line.size(), 0.0);
  for (double& z : line.z_m) z += shift.z();
}

}  // namespace road
