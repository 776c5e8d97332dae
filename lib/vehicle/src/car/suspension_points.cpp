#include "vehicle/suspension_points.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "vehicle/error.h"

namespace vehicle {
namespace {

using Vector5 = Eigen::Matrix<double, 5, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;

Eigen::Vector3d eigen(const Vec3<double>& v) { return {v.x, v.y, v.z}; }
Vec3<double> plain(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

struct Pose {
  Eigen::Vector3d wheel;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
};

/// Moves the pose to the given height of the wheel centre, links at their lengths.
void move_to(const SuspensionPoints& points, double z_m, double rack_m, double travel_m,
             Pose& pose) {
  const Eigen::Vector3d wheel0 = eigen(points.wheel_m);
  pose.wheel.z() = z_m;
  for (int round = 0; round < 30; ++round) {
    Vector5 residual;
    Matrix5 jacobian;  // by x and y of the wheel centre, and a small turn
    for (int k = 0; k < 5; ++k) {
      const SuspensionPoints::Link& link = points.link[static_cast<std::size_t>(k)];
      const double length = (eigen(link.outer_m) - eigen(link.inner_m)).norm();
      Eigen::Vector3d inner = eigen(link.inner_m);
      if (k == 4) inner.y() += rack_m;
      const Eigen::Vector3d arm = pose.R * (eigen(link.outer_m) - wheel0);
      const Eigen::Vector3d along = pose.wheel + arm - inner;
      const double now = along.norm();
      const Eigen::Vector3d unit = along / std::max(now, 1e-12);
      const Eigen::Vector3d turn = arm.cross(unit);
      residual[k] = now - length;
      jacobian.row(k) << unit.x(), unit.y(), turn.x(), turn.y(), turn.z();
    }
    if (!residual.allFinite()) break;
    if (residual.lpNorm<Eigen::Infinity>() < 1e-13) return;
    const Eigen::FullPivLU<Matrix5> lu(jacobian);
    if (!lu.isInvertible() || !(lu.rcond() >= 1e-9))
      throw Error(fmt::format(
          "suspension points: at a travel of {:.4f} m the links do not hold the upright; wanted "
          "five links in different directions, and a travel_m that they allow",
          travel_m));
    const Vector5 change = lu.solve(-residual);
    if (round > 3 && residual.lpNorm<Eigen::Infinity>() < 1e-12) return;
    pose.wheel.x() += change[0];
    pose.wheel.y() += change[1];
    const Eigen::Vector3d turn = change.tail<3>();
    const double angle = turn.norm();
    if (angle > 0.0) pose.R = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() * pose.R;
  }
  throw Error(fmt::format(
      "suspension points: the links do not reach a travel of {:.4f} m; make travel_m smaller or "
      "look at the points",
      travel_m));
}

}  // namespace

UprightPose solve_suspension(const SuspensionPoints& points, double travel_m, double rack_m) {
  Pose pose;
  pose.wheel = eigen(points.wheel_m);
  const double far = std::max(std::abs(travel_m), std::abs(rack_m));
  const int steps = std::max(1, static_cast<int>(std::ceil(std::min(far, 10.0) / 0.01)));
  for (int i = 1; i <= steps; ++i) {
    const double share = static_cast<double>(i) / steps;
    move_to(points, points.wheel_m.z + share * travel_m, share * rack_m, share * travel_m, pose);
  }
  UprightPose out;
  out.wheel_m = plain(pose.wheel);
  for (int k = 0; k < 3; ++k) out.direction[static_cast<std::size_t>(k)] = plain(pose.R.col(k));
  // The wheel's axis, y to the left: as dynamics.h turns it by -camber about x and -toe about z.
  const Vec3<double>& axis = out.direction[1];
  out.camber_rad = -std::asin(std::clamp(axis.z, -1.0, 1.0));
  out.toe_rad = std::atan2(axis.x, axis.y);
  return out;
}

WheelPath make_wheel_path(const SuspensionPoints& points) {
  if (!(points.range_m > 0.0) || !(points.range_m <= 0.5))
    throw Error(fmt::format("suspension points: travel_m = {}, wanted 0 to 0.5", points.range_m));
  constexpr int n = static_cast<int>(WheelPath::kDegree);
  using Vector = Eigen::Matrix<double, n, 1>;
  using Matrix = Eigen::Matrix<double, n, n>;
  const auto values = [&](double travel_m) {
    const UprightPose at = solve_suspension(points, travel_m);
    return std::array<double, 4>{at.wheel_m.x - points.wheel_m.x, at.wheel_m.y - points.wheel_m.y,
                                 at.camber_rad, at.toe_rad};
  };
  // Through the design position and six Chebyshev places: (value over travel) of degree 5.
  Matrix powers;
  std::array<Vector, 4> right;
  for (int i = 0; i < n; ++i) {
    const double x = std::cos(std::numbers::pi * (i + 0.5) / n);
    for (int k = 0; k < n; ++k) powers(i, k) = std::pow(x, k);
    const std::array<double, 4> at = values(x * points.range_m);
    for (std::size_t q = 0; q < 4; ++q) right[q][i] = at[q] / x;
  }
  const Eigen::PartialPivLU<Matrix> lu(powers);
  WheelPath path;
  path.range_m = points.range_m;
  const std::array<WheelPath::Coefficients*, 4> parts{&path.ahead_m, &path.outward_m,
                                                      &path.camber_rad, &path.toe_rad};
  for (std::size_t q = 0; q < 4; ++q) {
    const Vector c = lu.solve(right[q]);
    for (int k = 0; k < n; ++k)
      (*parts[q])[static_cast<std::size_t>(k)] = c[k] / std::pow(points.range_m, k + 1);
  }
  for (int i = -10; i <= 10; ++i) {
    const double travel_m = points.range_m * i / 10.0;
    const std::array<double, 4> at = values(travel_m);
    for (std::size_t q = 0; q < 4; ++q) {
      const double off = std::abs(along_travel(*parts[q], points.range_m, travel_m).value - at[q]);
      if (!(off < 2e-5))
        throw Error(fmt::format(
            "suspension points: polynomials miss the path by {:.1e} at a travel of {:.3f} m; make "
            "travel_m smaller",
            off, travel_m));
    }
  }
  return path;
}

}  // namespace vehicle
