// A border of the road, or the middle of it, as a smooth curve through points. Private to
// trace_centreline.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

namespace road {

/// A point with its place along the walk.
struct BorderPoint {
  double s_m;
  Eigen::Vector3d point;
};

/// Piecewise cubic through points, tangents from the circle through three neighbours.
class BorderCurve {
 public:
  BorderCurve(std::vector<BorderPoint> points, bool closed);

  std::size_t size() const { return points_.size(); }
  const BorderPoint& operator[](std::size_t i) const { return points_[i]; }
  const Eigen::Vector2d& tangent(std::size_t i) const { return tangents_[i]; }
  std::size_t segments() const { return closed_ ? points_.size() : points_.size() - 1; }
  std::size_t next(std::size_t i) const { return i + 1 == points_.size() ? 0 : i + 1; }

  /// Point and direction at share t in [0, 1] of segment i.
  std::pair<Eigen::Vector3d, Eigen::Vector2d> at(std::size_t i, double t) const;

  /// Segment whose stretch of s holds s_m.
  std::size_t segment_of(double s_m) const;

 private:
  Eigen::Vector2d xy(std::size_t i) const { return points_[i].point.head<2>(); }
  std::vector<BorderPoint> points_;
  std::vector<Eigen::Vector2d> tangents_;
  bool closed_;
};

/// The curve through points whose places along the road do not matter.
BorderCurve curve_through(const std::vector<Eigen::Vector3d>& points_m, bool closed);

/// Length along the cubic through the stations; 8 chords per segment keep the error below 1e-6 of
/// it.
double curve_length_m(const std::vector<Eigen::Vector3d>& points_m, bool closed);

}  // namespace road
