#include "border_curve.h"

#include <algorithm>
#include <cmath>

namespace road {

using Eigen::Vector2d;
using Eigen::Vector3d;

BorderCurve::BorderCurve(std::vector<BorderPoint> points, bool closed)
    : points_(std::move(points)), closed_(closed) {
  const std::size_t n = points_.size();
  tangents_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const bool first = i == 0 && !closed_, last = i + 1 == n && !closed_;
    const Vector2d here = xy(i);
    const Vector2d a = first ? Vector2d(xy(i + 1) - here) : Vector2d(here - xy((i + n - 1) % n));
    const Vector2d b = last ? a : Vector2d(xy((i + 1) % n) - here);
    const double la = std::max(a.norm(), 1e-9), lb = std::max(b.norm(), 1e-9);
    // Weighted so that points on a circle give its exact tangent, whatever their spacing.
    tangents_[i] = (a / la * lb + b / lb * la).normalized();
  }
}

std::pair<Vector3d, Vector2d> BorderCurve::at(std::size_t i, double t) const {
  const std::size_t j = next(i);
  const Vector3d &p = points_[i].point, &q = points_[j].point;
  const double length = (q - p).head<2>().norm();
  const Vector2d m0 = length * tangents_[i], m1 = length * tangents_[j];
  const double t2 = t * t, t3 = t2 * t;
  const Vector2d position = (2 * t3 - 3 * t2 + 1) * p.head<2>() + (t3 - 2 * t2 + t) * m0 +
                            (-2 * t3 + 3 * t2) * q.head<2>() + (t3 - t2) * m1;
  const Vector2d derivative = (6 * t2 - 6 * t) * p.head<2>() + (3 * t2 - 4 * t + 1) * m0 +
                              (-6 * t2 + 6 * t) * q.head<2>() + (3 * t2 - 2 * t) * m1;
  return {{position.x(), position.y(), p.z() + t * (q.z() - p.z())}, derivative.normalized()};
}

std::size_t BorderCurve::segment_of(double s_m) const {
  const auto after = std::upper_bound(points_.begin(), points_.end(), s_m,
                                      [](double s, const BorderPoint& p) { return s < p.s_m; });
  if (after == points_.begin()) return closed_ ? points_.size() - 1 : 0;
  return std::min<std::size_t>(static_cast<std::size_t>(after - points_.begin()) - 1,
                               segments() - 1);
}

BorderCurve curve_through(const std::vector<Vector3d>& points_m, bool closed) {
  std::vector<BorderPoint> points;
  points.reserve(points_m.size());
  for (const Vector3d& p : points_m) points.push_back({0.0, p});
  return {std::move(points), closed};
}

double curve_length_m(const std::vector<Vector3d>& points_m, bool closed) {
  const BorderCurve curve = curve_through(points_m, closed);
  double length = 0.0;
  for (std::size_t i = 0; i < curve.segments(); ++i) {
    Vector2d last = curve.at(i, 0.0).first.head<2>();
    for (int k = 1; k <= 8; ++k) {
      const Vector2d next = curve.at(i, k / 8.0).first.head<2>();
      length += (next - last).norm();
      last = next;
    }
  }
  return length;
}

}  // namespace road
