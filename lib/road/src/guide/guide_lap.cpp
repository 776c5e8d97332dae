#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "mesh/error.h"
#include "road/guide.h"
#include "road/road_graph.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kMostPointsOfLap = 4000;  // of which a lap is looked for
constexpr double kSameWay = 0.7;     // cosine between the directions of two laps at one place
constexpr double kMost_m = 10.0;     // between two laps at one place: the width of a road
constexpr double kMostShare = 0.01;  // of the whole length, for models
constexpr double kRoomShare = 0.05;  // of the length, between the end and the beginning of a lap;
constexpr double kRoom_m = 300.0;    // enough however many laps there are
constexpr double kRepeatedShare =
    0.3;                           // of the length is driven twice where there are several laps,
constexpr double kLapShare = 0.5;  // or one lap is so much of it; else it is a helix

double apart_m(const Vector3d& a, const Vector3d& b) { return (a - b).head<2>().norm(); }

/// Without repetitions, which have no direction, and thinned to at most kMostPointsOfLap.
std::vector<Vector3d> different(const std::vector<Vector3d>& points_m) {
  double length_m = 0.0;
  for (std::size_t i = 1; i < points_m.size(); ++i)
    length_m += apart_m(points_m[i], points_m[i - 1]);
  const double least_m = std::max(
      length_m / 1e6, points_m.size() > kMostPointsOfLap ? length_m / kMostPointsOfLap : 0.0);
  std::vector<Vector3d> kept;
  for (const Vector3d& p : points_m)
    if (kept.empty() || apart_m(p, kept.back()) > least_m) kept.push_back(p);
  return kept;
}

/// Where a way passes a place of its own a second time, the same way round.
struct Return {
  std::size_t from = 0, to = 0;  ///< points of the way
  double apart_m = std::numeric_limits<double>::infinity();
  double length_share = 0.0;    ///< of the way, in between
  double repeated_share = 0.0;  ///< of the way that lies where it was before
};

Return best_return(const std::vector<Vector3d>& way) {
  const std::size_t n = way.size();
  std::vector<double> s_m{0.0};
  for (std::size_t i = 1; i < n; ++i) s_m.push_back(s_m.back() + apart_m(way[i], way[i - 1]));
  const double most_m = std::min(kMost_m, kMostShare * s_m.back());
  const auto heading = [&](std::size_t i) -> Vector2d {
    return (way[std::min(i + 1, n - 1)] - way[i == 0 ? 0 : i - 1]).head<2>().normalized();
  };
  const double least_m = std::max(10.0 * most_m, std::min(kRoom_m, kRoomShare * s_m.back()));
  Return best;
  double repeated_m = 0.0;
  for (std::size_t j = 1; j < n; ++j) {
    // The latest place of this kind: one lap, not two.
    for (std::size_t i = j; i-- > 0;) {
      if (s_m[j] - s_m[i] < least_m) continue;
      const Vector2d along = (way[i + 1] - way[i]).head<2>();
      const double t =
          std::clamp((way[j] - way[i]).head<2>().dot(along) / along.squaredNorm(), 0.0, 1.0);
      const Vector3d there = way[i] + t * (way[i + 1] - way[i]);
      if (s_m[j] - s_m[i] - t * along.norm() < least_m) continue;
      const double d = apart_m(way[j], there);
      const bool other_deck =
          std::abs(way[j].z() - there.z()) > 0.5 * kMost_m;  // false where unknown
      if (d > most_m || other_deck || heading(j).dot(along.normalized()) < kSameWay) continue;
      repeated_m += s_m[j] - s_m[j - 1];
      if (d < best.apart_m) best = {i + 1, j, d, (s_m[j] - s_m[i]) / s_m.back(), 0.0};
      break;
    }
  }
  best.repeated_share = repeated_m / s_m.back();
  return best;
}

/// Whether the last point leads on to the first.
bool comes_back(const std::vector<Vector3d>& way) {
  const std::size_t n = way.size();
  std::vector<double> steps_m;
  double length_m = 0.0;
  for (std::size_t i = 1; i < n; ++i)
    steps_m.push_back(apart_m(way[i], way[i - 1])), length_m += steps_m.back();
  const double room_m = apart_m(way.front(), way.back());
  const double longest_m = *std::max_element(steps_m.begin(), steps_m.end());
  if (room_m > std::max(kRoomShare * length_m, std::min(1.5 * longest_m, 0.3 * length_m)))
    return false;
  const Vector2d over = (way.front() - way.back()).head<2>();
  if (room_m < 1e-3 * length_m) return true;
  // Directions over a stretch: single points are metres off.
  std::size_t ahead = 1, behind = n - 2;
  while (ahead + 1 < n && apart_m(way[ahead], way.front()) < kRoomShare * length_m) ++ahead;
  while (behind > 0 && apart_m(way[behind], way.back()) < kRoomShare * length_m) --behind;
  const Vector2d first = (way[ahead] - way.front()).head<2>().normalized(),
                 last = (way.back() - way[behind]).head<2>().normalized();
  if (room_m <= 1.5 * longest_m) return first.dot(last) > 0.0;
  return over.normalized().dot(first) > 0.0 && over.normalized().dot(last) > 0.0;
}

}  // namespace

Guide guide_along(const std::vector<Vector3d>& points_m) {
  std::vector<Vector3d> way = different(points_m);
  if (way.size() < 3)
    throw Error(fmt::format(
        "the guide has {} different positions; wanted at least 3, in the order of driving",
        way.size()));
  const Return lap = best_return(way);
  const bool is_lap =
      lap.to >= lap.from + 3 &&
      (lap.repeated_share >= kRepeatedShare || (lap.length_share >= kLapShare && !comes_back(way)));
  if (is_lap)
    way = {way.begin() + static_cast<std::ptrdiff_t>(lap.from),
           way.begin() + static_cast<std::ptrdiff_t>(lap.to)};
  Guide guide{std::move(way), false};
  guide.closed = is_lap || comes_back(guide.points_m);
  if (guide.closed && apart_m(guide.points_m.front(), guide.points_m.back()) < 1e-3)
    guide.points_m.pop_back();
  if (guide.points_m.size() < 3)
    throw Error("the guide has 2 different positions; wanted at least 3, in the order of driving");
  return guide;
}

}  // namespace road
