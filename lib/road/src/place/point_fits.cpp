#include "point_fits.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <numeric>

namespace road {

Indices all_of(std::size_t count) {
  Indices all(count);
  std::iota(all.begin(), all.end(), std::size_t{0});
  return all;
}

RotoTranslation fit(const std::vector<ControlPoint>& points, const Indices& used, double mirror) {
  Eigen::Vector3d mesh_mean = Eigen::Vector3d::Zero(), global_mean = Eigen::Vector3d::Zero();
  const auto mesh = [&](std::size_t i) {
    return Eigen::Vector3d(points[i].mesh_m.x(), mirror * points[i].mesh_m.y(),
                           points[i].mesh_m.z());
  };
  for (const std::size_t i : used) {
    mesh_mean += mesh(i) / static_cast<double>(used.size());
    global_mean += points[i].global_m / static_cast<double>(used.size());
  }
  double cross = 0.0, dot = 0.0;
  for (const std::size_t i : used) {
    const Eigen::Vector2d a = (mesh(i) - mesh_mean).head<2>(),
                          b = (points[i].global_m - global_mean).head<2>();
    cross += a.x() * b.y() - a.y() * b.x();
    dot += a.dot(b);
  }
  RotoTranslation T;
  T.yaw_rad = std::atan2(cross, dot);
  T.translation_m =
      global_mean - Eigen::AngleAxisd(T.yaw_rad, Eigen::Vector3d::UnitZ()) * mesh_mean;
  return T;
}

double residual(const RotoTranslation& T, const ControlPoint& point, double mirror) {
  const Eigen::Vector3d mesh(point.mesh_m.x(), mirror * point.mesh_m.y(), point.mesh_m.z());
  return (Eigen::AngleAxisd(T.yaw_rad, Eigen::Vector3d::UnitZ()) * mesh + T.translation_m -
          point.global_m)
      .norm();
}

double rms(const RotoTranslation& T, const std::vector<ControlPoint>& points, const Indices& used,
           double mirror) {
  double sum = 0.0;
  for (const std::size_t i : used) sum += std::pow(residual(T, points[i], mirror), 2);
  return std::sqrt(sum / static_cast<double>(used.size()));
}

double residual(const Similarity& T, const ControlPoint& point) {
  return (T.scale * (T.rotation * point.mesh_m) + T.translation_m - point.global_m).norm();
}

double rms(const Similarity& T, const std::vector<ControlPoint>& points, const Indices& used) {
  double sum = 0.0;
  for (const std::size_t i : used) sum += std::pow(residual(T, points[i]), 2);
  return std::sqrt(sum / static_cast<double>(used.size()));
}

base::Answer<Similarity> fit_as(const AlignOptions& options,
                                const std::vector<ControlPoint>& points, const Indices& used) {
  if (options.rotation == AlignOptions::Rotation::free) {
    std::vector<ControlPoint> some;
    for (const std::size_t i : used) some.push_back(points[i]);
    return fit_similarity(some, options.scale);
  }
  Similarity T;
  T.rotation = Eigen::AngleAxisd(fit(points, used).yaw_rad, Eigen::Vector3d::UnitZ());
  Eigen::Vector3d mesh_mean = Eigen::Vector3d::Zero(), global_mean = Eigen::Vector3d::Zero();
  for (const std::size_t i : used) {
    mesh_mean += points[i].mesh_m / static_cast<double>(used.size());
    global_mean += points[i].global_m / static_cast<double>(used.size());
  }
  if (options.scale) {
    double product = 0.0, square = 0.0;
    for (const std::size_t i : used) {
      const Eigen::Vector3d a = T.rotation * (points[i].mesh_m - mesh_mean);
      product += a.dot(points[i].global_m - global_mean);
      square += a.squaredNorm();
    }
    T.scale = product / square;
  }
  T.translation_m = global_mean - T.scale * (T.rotation * mesh_mean);
  return T;
}

namespace {

/// The rotation that brings the columns of `a` nearest to those of `b`, both about their means: the
/// unit quaternion of the largest eigenvalue (Horn 1987, J. Opt. Soc. Am. A 4, p. 629).
Eigen::Quaterniond best_rotation(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b) {
  const Eigen::Matrix3d S = a * b.transpose();
  Eigen::Matrix4d N;
  N(0, 0) = S.trace();
  N.bottomRightCorner<3, 3>() = S + S.transpose() - S.trace() * Eigen::Matrix3d::Identity();
  N.bottomLeftCorner<3, 1>() =
      Eigen::Vector3d(S(1, 2) - S(2, 1), S(2, 0) - S(0, 2), S(0, 1) - S(1, 0));
  N.topRightCorner<1, 3>() = N.bottomLeftCorner<3, 1>().transpose();
  const Eigen::Vector4d q = Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(N).eigenvectors().col(3);
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
}

}  // namespace

base::Answer<Similarity> fit_similarity(const std::vector<ControlPoint>& points, bool with_scale) {
  const auto count = static_cast<Eigen::Index>(points.size());
  Eigen::Matrix3Xd mesh(3, count), global(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    mesh.col(i) = points[static_cast<std::size_t>(i)].mesh_m;
    global.col(i) = points[static_cast<std::size_t>(i)].global_m;
  }
  if (count >= 1) {
    // Centred first: UTM coordinates would cost the products half of their digits.
    const Eigen::Vector3d mesh_mean = mesh.rowwise().mean(), global_mean = global.rowwise().mean();
    const Eigen::Matrix3Xd a = mesh.colwise() - mesh_mean, b = global.colwise() - global_mean;
    const Eigen::Matrix3d spread = a * a.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> extent_2(spread);
    if (count >= 3 && extent_2.eigenvalues()[1] >= kSmallestSpread_m * kSmallestSpread_m) {
      Similarity out;
      out.rotation = best_rotation(a, b);
      const Eigen::Matrix3d turn(out.rotation);
      if (with_scale) out.scale = (b.array() * (turn * a).array()).sum() / spread.trace();
      const Eigen::Matrix3d linear = out.scale * turn;
      out.translation_m = global_mean - linear * mesh_mean;
      double sum = 0.0;
      for (Eigen::Index i = 0; i < count; ++i) {
        out.residual_m.push_back((linear * a.col(i) - b.col(i)).norm());
        sum += out.residual_m.back() * out.residual_m.back();
      }
      out.rms_m = std::sqrt(sum / static_cast<double>(count));
      return out;
    }
  }
  return base::Refusal(fmt::format(
      "{} control points that span no plane; a free rotation needs at least 3, not all on one line",
      points.size()));
}

}  // namespace road
