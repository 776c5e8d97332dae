#include "border_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <tuple>
#include <vector>

namespace border_curve_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using road::BorderCurve;

constexpr double kRadius_m = 30.0;

Vector3d on_circle(double angle_rad) {
  return {kRadius_m * std::cos(angle_rad), kRadius_m * std::sin(angle_rad), 2.0};
}

/// Unevenly far apart.
std::vector<Vector3d> circle(double end_rad) {
  std::vector<Vector3d> out;
  for (int k = 0; 0.1 * k + 0.03 * std::sin(k) < end_rad; ++k)
    out.push_back(on_circle(0.1 * k + 0.03 * std::sin(k)));
  return out;
}

}  // namespace

TEST(BorderCurve, TangentsOfACircleAreExactAndItsEndsFollowTheChord) {
  const std::vector<Vector3d> points = circle(2.0);
  const BorderCurve curve = road::curve_through(points, false);
  for (std::size_t i = 1; i + 1 < curve.size(); ++i) {
    const Vector2d across = points[i].head<2>() / kRadius_m;
    EXPECT_NEAR(curve.tangent(i).dot(Vector2d(-across.y(), across.x())), 1.0, 1e-12) << i;
  }
  const std::size_t last = points.size() - 1;
  for (const auto& [end, from, to] :
       {std::tuple{std::size_t{0}, std::size_t{0}, std::size_t{1}}, {last, last - 1, last}}) {
    const Vector2d chord = (points[to] - points[from]).head<2>().normalized();
    EXPECT_NEAR(curve.tangent(end).dot(chord), 1.0, 1e-12) << end;
    EXPECT_NEAR(curve.tangent(end).norm(), 1.0, 1e-12) << end;
  }
}

TEST(BorderCurve, GoesThroughItsPointsAndKeepsToTheCircleBetween) {
  const std::vector<Vector3d> points = circle(2.0 * std::numbers::pi - 0.05);
  const BorderCurve curve = road::curve_through(points, true);
  for (std::size_t i = 0; i < curve.segments(); ++i) {
    EXPECT_LT((curve.at(i, 0.0).first - points[i]).norm(), 1e-12) << i;
    EXPECT_LT((curve.at(i, 1.0).first - points[curve.next(i)]).norm(), 1e-12) << i;
    const auto [middle, direction] = curve.at(i, 0.5);
    EXPECT_NEAR(middle.head<2>().norm(), kRadius_m, 1e-4) << i;
    EXPECT_LT(std::abs(direction.dot(middle.head<2>().normalized())), 1e-3) << i;
    EXPECT_NEAR(middle.z(), 2.0, 1e-12);
  }
  const double round_m = 2.0 * std::numbers::pi * kRadius_m;
  EXPECT_NEAR(road::curve_length_m(points, true), round_m, 1e-4 * round_m);
}

}  // namespace border_curve_test
