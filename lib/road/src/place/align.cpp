#include "road/align.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "outliers.h"
#include "point_fits.h"

namespace road {
namespace {

// An alignment that leaves more than this share of the extent is none; surveys leave a thousandth.
constexpr double kWorstFit = 0.02;
constexpr double kWorstFit_m = 1.0;
constexpr double kSteepestTilt_rad =
    20.0 * std::numbers::pi / 180.0;   // more is another axis that points up
constexpr double kLargestScale = 2.0;  // more, or less than its inverse, is another unit

double spread(const std::vector<ControlPoint>& points, const Indices& used) {
  double widest = 0.0;
  for (const std::size_t i : used) {
    for (const std::size_t j : used)
      widest = std::max(widest, (points[i].mesh_m - points[j].mesh_m).head<2>().norm());
  }
  return widest;
}

/// Why nothing fits, where the reason has a name.
std::string reason_of_misfit(const std::vector<ControlPoint>& points, const Indices& used,
                             double rms_m) {
  const double mirrored_m = rms(fit(points, used, -1.0), points, used, -1.0);
  double mesh_m = 0.0, global_m = 0.0;
  for (const std::size_t i : used) {
    for (const std::size_t j : used) {
      mesh_m += (points[i].mesh_m - points[j].mesh_m).head<2>().norm();
      global_m += (points[i].global_m - points[j].global_m).head<2>().norm();
    }
  }
  const double ratio = global_m / mesh_m;
  if (mirrored_m < 0.2 * rms_m)
    return "their mirror image fits; look for latitude and longitude swapped, a wrong hemisphere "
           "or a wrong axis";
  if (std::abs(ratio - 1.0) > kWorstFit)
    return fmt::format("their distances are {:.4g} times those in the mesh; look for a wrong unit",
                       ratio);
  return "check which point is which";
}

/// The motion as what the mesh does and what the road does after it.
void take_apart(const Similarity& T, const Eigen::Vector3d& about_m, AlignReport& report) {
  const Eigen::Quaterniond all(T.rotation);
  const Eigen::Quaterniond about_z = Eigen::Quaterniond(all.w(), 0.0, 0.0, all.z()).normalized();
  const Eigen::Quaterniond tilt = about_z.conjugate() * all;
  report.T_global_mesh.yaw_rad =
      std::remainder(2.0 * std::atan2(about_z.z(), about_z.w()), 2.0 * std::numbers::pi);
  report.tilt_and_scale.about_m = about_m;
  report.tilt_and_scale.linear = T.scale * tilt.toRotationMatrix();
  report.T_global_mesh.translation_m =
      T.scale * (T.rotation * about_m) + T.translation_m - about_z * about_m;
  report.tilt_rad = Eigen::AngleAxisd(tilt).angle();
  report.scale = T.scale;
}

/// Why, where the points lie too near to each other to fix a rotation.
std::optional<base::Refusal> too_narrow(const std::vector<ControlPoint>& points,
                                        const Indices& used) {
  const double spread_m = spread(points, used);
  if (spread_m >= kSmallestSpread_m) return std::nullopt;
  return base::Refusal(
      fmt::format("the control points lie within {:.2f} m of each other; wanted at least {} m so "
                  "that they fix a rotation",
                  spread_m, kSmallestSpread_m));
}

}  // namespace

base::Answer<AlignReport> try_fit_alignment(const std::vector<ControlPoint>& points,
                                            const AlignOptions& options) {
  const bool free = options.rotation == AlignOptions::Rotation::free;
  if (points.size() < (free ? 3 : 2)) {
    return base::Refusal(
        free ? fmt::format(
                   "{} control points; a free rotation needs at least 3, not all on one line",
                   points.size())
             : fmt::format("{} control points; an alignment needs at least 2", points.size()));
  }
  const Indices all = all_of(points.size());
  if (auto narrow = too_narrow(points, all)) return *std::move(narrow);
  const auto of_all = fit_as(options, points, all);
  if (!of_all) return of_all.refusal();  // points on one line, before any is left out
  const auto kept = inliers(points, options);
  if (!kept) return kept.refusal();
  const Indices& used = *kept;
  if (auto narrow = too_narrow(points, used)) return *std::move(narrow);
  const double spread_m = spread(points, used);
  const auto fitted = fit_as(options, points, used);
  if (!fitted) return fitted.refusal();
  const Similarity& motion = *fitted;
  AlignReport report;
  report.rms_m = rms(motion, points, used);
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    report.residual_m.push_back(residual(motion, points[i]));
    middle_m += points[i].mesh_m / static_cast<double>(points.size());
    if (!std::binary_search(used.begin(), used.end(), i)) report.outliers.push_back(points[i].name);
  }
  const double worst_m = std::max(kWorstFit_m, kWorstFit * spread_m);
  if (report.rms_m > worst_m) {
    return base::Refusal(
        fmt::format("no rotation and translation fits the {} control points: {:.2f} m rms left "
                    "over {:.0f} m; wanted at most "
                    "{:.2f} m; {}",
                    used.size(), report.rms_m, spread_m, worst_m,
                    reason_of_misfit(points, used, report.rms_m)));
  }
  if (free || options.scale) take_apart(motion, middle_m, report);
  if (free && report.tilt_rad > kSteepestTilt_rad) {
    return base::Refusal(
        fmt::format("the {} control points tilt the mesh by {:.1f} degrees; wanted at most {:.0f}; "
                    "look for another axis that points "
                    "up (--up), or latitude and longitude swapped",
                    used.size(), report.tilt_rad * 180.0 / std::numbers::pi,
                    kSteepestTilt_rad * 180.0 / std::numbers::pi));
  }
  if (options.scale && !(motion.scale <= kLargestScale && motion.scale >= 1.0 / kLargestScale)) {
    return base::Refusal(
        fmt::format("the {} control points scale the mesh by {:.4g}; wanted {} to {}; look for a "
                    "wrong unit (--unit)",
                    used.size(), motion.scale, 1.0 / kLargestScale, kLargestScale));
  }
  if (free) return report;
  report.tilt_rad = std::numeric_limits<double>::quiet_NaN();
  if (!options.scale) report.T_global_mesh = fit(points, used);
  if (used.size() >= 3) {
    std::vector<ControlPoint> some;
    for (const std::size_t i : used) some.push_back(points[i]);
    // On a line: what was not applied stays NaN, as the header says.
    if (const auto check = fit_similarity(some, true)) {
      report.scale = options.scale ? motion.scale : check->scale;
      report.tilt_rad = std::acos(std::clamp(check->rotation(2, 2), -1.0, 1.0));
    }
  }
  return report;
}

AlignReport fit_alignment(const std::vector<ControlPoint>& points, const AlignOptions& options) {
  return try_fit_alignment(points, options).or_throw();
}

void apply_to_mesh(const TiltAndScale& tilt_and_scale, Mesh& mesh) {
  if (tilt_and_scale.is_identity()) return;
  mesh.origin_m = tilt_and_scale(mesh.origin_m);
  for (Eigen::Vector3d& p : mesh.vertices_m) p = tilt_and_scale.linear * p;
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
