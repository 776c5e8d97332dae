#include "overhang.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace cloud {
namespace {

constexpr std::size_t kLeastGround = 6;  // three of them fix the plane
constexpr double kLeastShare = 1.0 / 3.0;
// Of the plane's scatter: nine of ten planes of 6 points keep to it.
constexpr double kTimesNoise = 1.5, kNoiseFloor_m = 0.0003;

/// Heights of the points over the plane of those that are `kept`.
void above_plane(const std::vector<EdgePoint>& points, const std::vector<std::uint8_t>& kept,
                 std::vector<double>& above_m) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (kept[k] == 0) continue;
    const Eigen::Vector3d row(1.0, static_cast<double>(points[k].a_m),
                              static_cast<double>(points[k].b_m));
    normal += row * row.transpose();
    right += row * static_cast<double>(points[k].height_m);
  }
  normal.diagonal().tail<2>().array() += 1e-6 * normal(0, 0);  // points in a line
  const Eigen::Vector3d plane = normal.ldlt().solve(right);
  for (std::size_t k = 0; k < points.size(); ++k)
    above_m[k] = static_cast<double>(points[k].height_m) - plane[0] -
                 plane[1] * static_cast<double>(points[k].a_m) -
                 plane[2] * static_cast<double>(points[k].b_m);
}

}  // namespace

double bend_of(const RoadFrame& frame, const GridPlace& place) {
  const double bend_m = 0.5 * (frame.height({place.row, place.v_m - 0.25}) +
                               frame.height({place.row, place.v_m + 0.25})) -
                        frame.height(place);
  return std::isfinite(bend_m) ? std::abs(bend_m) : 0.0;
}

// An edge in the middle of a cell of 0.5 m: heights s |b| / 2 about it, b even in 0.25 m, deviate
// by s 0.25 m / (2 sqrt(12)); the bend is s 0.25 m / 2.
double scatter_of_bend_m(double bend_m) { return bend_m / std::sqrt(12.0); }

double most_above_ground_m(double noise_m) { return 3.0 * noise_m + 0.001; }

std::vector<std::uint8_t> ground_among(const std::vector<EdgePoint>& points, double noise_m) {
  const double most_m = most_above_ground_m(noise_m);
  std::vector<std::uint8_t> kept(points.size(), 1);
  std::vector<double> above_m(points.size());
  const auto least = std::max(
      kLeastGround, static_cast<std::size_t>(kLeastShare * static_cast<double>(points.size())));
  for (std::size_t count = points.size();;) {
    if (count < least) return {};
    above_plane(points, kept, above_m);
    double top_m = 0.0, bottom_m = 0.0;
    for (std::size_t k = 0; k < points.size(); ++k)
      if (kept[k] != 0)
        top_m = std::max(top_m, above_m[k]), bottom_m = std::min(bottom_m, above_m[k]);
    if (top_m <= most_m) {
      if (bottom_m < -most_m) return {};
      break;
    }
    // The highest first: they tilt the plane most.
    for (std::size_t k = 0; k < points.size(); ++k)
      if (kept[k] != 0 && above_m[k] > std::max(most_m, 0.5 * top_m)) kept[k] = 0, --count;
  }
  double square_m2 = 0.0;
  std::size_t count = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    // The first planes were tilted: what they left out may lie on the last.
    kept[k] = std::abs(above_m[k]) <= most_m ? 1 : 0;
    if (kept[k] != 0) square_m2 += above_m[k] * above_m[k], ++count;
  }
  const double allowed_m = kTimesNoise * noise_m + kNoiseFloor_m;
  if (square_m2 > allowed_m * allowed_m * static_cast<double>(count - 3)) return {};
  return kept;
}

}  // namespace cloud
