#include "change_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/statistics.h"

namespace cloud {
namespace {

constexpr double kLeastScatter_m = 1e-3;  // of points about a plane: rounding of coordinates
constexpr std::size_t kFewest = 4;        // points of each campaign
constexpr int kRounds = 10;

struct Point {
  double x, y, z;
  std::size_t which;
};

std::vector<Point> points_of(const Held& cell) {
  std::vector<Point> all;
  for (const std::size_t k : {0u, 1u})
    for (const Eigen::Vector3f& p : cell.points[k])
      all.push_back(
          {static_cast<double>(p.x()), static_cast<double>(p.y()), static_cast<double>(p.z()), k});
  return all;
}

/// Heights of old and new, slopes along x and y.
using Plane = Eigen::Vector4d;
/// A value of each campaign.
using Both = std::array<double, 2>;

double residual(const Point& p, const Plane& plane) {
  return p.z - plane[static_cast<Eigen::Index>(p.which)] - plane[2] * p.x - plane[3] * p.y;
}

/// Distances of one campaign's points from the plane.
std::vector<double> distances(const std::vector<Point>& points, const Plane& plane,
                              std::size_t which) {
  std::vector<double> off;
  for (const Point& p : points)
    if (p.which == which) off.push_back(std::abs(residual(p, plane)));
  return off;
}

/// Flat, through that share of each campaign's heights.
Plane flat_at(const Held& cell, double share) {
  Plane plane = Plane::Zero();
  for (const std::size_t k : {0u, 1u}) {
    std::vector<double> heights;
    for (const Eigen::Vector3f& p : cell.points[k]) heights.push_back(static_cast<double>(p.z()));
    plane[static_cast<Eigen::Index>(k)] = base::quantile(heights, share);
  }
  return plane;
}

/// Of those near each surface: something high in the cell must not widen the gate.
Both scatter_about(const std::vector<Point>& points, const Plane& plane) {
  Both scatter{};
  for (const std::size_t k : {0u, 1u})
    // Of the nearer two thirds: a third may be of something else.
    scatter[k] = std::max(kLeastScatter_m, base::quantile(distances(points, plane, k), 0.45) / 0.6);
  return scatter;
}

/// Tukey's weights, of residuals in units of the gate.
bool is_inside(double t) { return std::abs(t) < 1.0; }
double weight_of(double t) { return (1.0 - t * t) * (1.0 - t * t); }
double gate_of(double scatter) { return 4.7 * scatter; }

/// What lies on the surface: weights in all, and variance about it.
struct OnSurface {
  Both weight{}, variance{};
};

OnSurface on_surface(const std::vector<Point>& points, const Plane& plane, const Both& scatter) {
  OnSurface on;
  Both square{};
  for (const Point& p : points) {
    const double r = residual(p, plane), t = r / gate_of(scatter[p.which]);
    if (!is_inside(t)) continue;
    const double w = weight_of(t);
    square[p.which] += w * r * r, on.weight[p.which] += w;
  }
  // The weights took a tenth away, the plane two points.
  for (const std::size_t k : {0u, 1u})
    on.variance[k] = std::max(kLeastScatter_m * kLeastScatter_m,
                              1.1 * square[k] / std::max(1.0, on.weight[k] - 2.0));
  return on;
}

struct NormalEquations {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
};

NormalEquations equations_of(const std::vector<Point>& points, const Plane& plane,
                             const Both& scatter, const Both& variance) {
  NormalEquations out;
  for (const Point& p : points) {
    const double r = residual(p, plane), t = r / gate_of(scatter[p.which]);
    if (!is_inside(t)) continue;
    const Eigen::Vector4d row(p.which == 0 ? 1.0 : 0.0, p.which == 1 ? 1.0 : 0.0, p.x, p.y);
    const double precision = weight_of(t) / variance[p.which];
    out.matrix += precision * row * row.transpose();
    out.right += precision * r * row;
  }
  // A slope of more than 1 or so is a wall: held loosely.
  out.matrix(2, 2) += 1.0, out.matrix(3, 3) += 1.0;
  out.right[2] -= plane[2], out.right[3] -= plane[3];
  return out;
}

/// The weights choose what agrees; where much does not, as in grass, it agrees by choice: how much
/// more most points scatter than those.
double spread_beyond(const std::vector<Point>& points, const Plane& plane, const Both& variance) {
  double spread = 1.0;
  for (const std::size_t k : {0u, 1u})
    spread = std::max(
        spread, base::quantile(distances(points, plane, k), 0.6) / 0.842 / std::sqrt(variance[k]));
  return spread;
}

/// From that share of the heights on.
CellFit fit_from(const Held& cell, double share) {
  CellFit fit;
  if (std::min(cell.points[0].size(), cell.points[1].size()) < kFewest) return fit;
  const std::vector<Point> points = points_of(cell);
  Plane plane = flat_at(cell, share);
  for (int round = 1; round <= kRounds; ++round) {
    const Both scatter = scatter_about(points, plane);
    const OnSurface on = on_surface(points, plane, scatter);
    if (std::min(on.weight[0], on.weight[1]) < 0.5 * static_cast<double>(kFewest)) return fit;
    const NormalEquations equations = equations_of(points, plane, scatter, on.variance);
    const Eigen::LDLT<Eigen::Matrix4d> solver(equations.matrix);
    const Eigen::Vector4d step = solver.solve(equations.right);
    plane += step;
    if (round < kRounds && !(step.cwiseAbs().maxCoeff() < 1e-6)) continue;
    const Eigen::Vector4d difference(-1.0, 1.0, 0.0, 0.0);
    fit.stddev_m = std::sqrt(std::max(0.0, difference.dot(solver.solve(difference))));
    fit.points = 2.0 / (1.0 / on.weight[0] + 1.0 / on.weight[1]);
    fit.stddev_m *= spread_beyond(points, plane, on.variance);
    break;
  }
  fit.old_m = cell.z0_m + plane[0], fit.change_m = plane[1] - plane[0];
  fit.done = std::isfinite(fit.change_m) && fit.stddev_m > 0.0;
  return fit;
}

}  // namespace

CellFit fit_cell(const Held& cell) {
  CellFit fit = fit_from(cell, 0.25);
  if (!fit.done) return fit;
  for (const double share : {0.4, 0.55}) {
    const CellFit other = fit_from(cell, share);
    fit.done &= other.done;
    fit.stddev_m = std::hypot(fit.stddev_m, other.change_m - fit.change_m);
  }
  return fit;
}

}  // namespace cloud
