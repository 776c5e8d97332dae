#include "edge_rungs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mesh/error.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kRungStep_m = 0.5;
constexpr double kWidest_m = 200.0;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace

Relation relate(const EdgeCurve& left, const EdgeCurve& right) {
  Relation relation;
  const std::size_t stride = std::max<std::size_t>(1, right.points_m.size() / 8000);
  const auto nearest = [&](const Vector2d& p, const auto& allowed) {
    double best = std::numeric_limits<double>::infinity(), best_s = 0.0;
    for (std::size_t k = 0; k < right.points_m.size(); k += stride) {
      const double distance = (right.points_m[k].head<2>() - p).squaredNorm();
      if (distance < best && allowed(k)) {
        best = distance;
        best_s = right.s_m[k];
      }
    }
    return best_s;
  };
  constexpr int kProbes = 200;
  for (int k = 0; k < kProbes; ++k) {
    const double s = left.length_m * k / kProbes;
    const Vector2d p = left.at(s).head<2>(), ahead = left.at(s + 1.0).head<2>() - p;
    const auto any = [](std::size_t) { return true; };
    const double at = nearest(p, any), after = nearest(p + ahead * 10.0, any);
    double moved = after - at;
    if (right.closed) moved = std::remainder(moved, right.length_m);
    (moved >= 0.0 ? relation.forward : relation.backward) += 1;
    (cross(ahead, right.at(at).head<2>() - p) < 0.0 ? relation.on_right : relation.on_left) += 1;
  }
  // The start of a figure-eight may lie on its crossing: only an edge that runs the same way
  // counts.
  const Vector2d start = left.at(0.0).head<2>(), ahead = left.at(1.0).head<2>() - start;
  const auto beside_start = [&](std::size_t k) {
    const Vector2d p = right.points_m[k].head<2>(),
                   along = right.at(right.s_m[k] + 1.0).head<2>() - p;
    return cross(ahead, p - start) < 0.0 &&
           std::abs(along.dot(ahead)) > 0.7 * along.norm() * ahead.norm();
  };
  relation.right_s_at_start_m = std::clamp(nearest(start, beside_start), 0.0, right.length_m);
  return relation;
}

std::vector<Rung> climb(const EdgeCurve& left, const EdgeCurve& right, double right_s_m) {
  std::vector<Rung> rungs{{0.0, right_s_m}};
  const double left_end = left.length_m,
               right_end = right.closed ? right_s_m + right.length_m : right.length_m;
  while (true) {
    Rung next = rungs.back();
    const bool left_done = next.left_s_m >= left_end, right_done = next.right_s_m >= right_end;
    if (left_done && right_done) break;
    if (!left.closed && (left_done || right_done)) break;
    const Rung by_left{std::min(left_end, next.left_s_m + kRungStep_m), next.right_s_m},
        by_right{next.left_s_m, std::min(right_end, next.right_s_m + kRungStep_m)};
    const auto length = [&](const Rung& r) {
      return (left.at(r.left_s_m) - right.at(r.right_s_m)).head<2>().norm();
    };
    next = left_done                             ? by_right
           : right_done                          ? by_left
           : length(by_left) <= length(by_right) ? by_left
                                                 : by_right;
    if (const double wide = length(next); !(wide <= kWidest_m)) {
      throw Error(
          fmt::format("the edges lie {:.0f} m apart {:.0f} m after the start of {}; wanted two "
                      "edges of one road, "
                      "at most {:.0f} m wide: are both files of one track, and complete?",
                      wide, next.left_s_m, left.path, kWidest_m));
    }
    rungs.push_back(next);
  }
  return rungs;
}

Centreline along(const EdgeCurve& left, const EdgeCurve& right, const std::vector<Rung>& rungs) {
  Centreline centreline;
  centreline.closed = left.closed;
  for (const Rung& rung : rungs) {
    const Vector3d l = left.at(rung.left_s_m), r = right.at(rung.right_s_m), middle = 0.5 * (l + r);
    auto& points = centreline.points_m;
    const double step = points.empty() ? kStationStep_m : (middle - points.back()).head<2>().norm();
    const bool round = centreline.closed && points.size() > 3 && &rung == &rungs.back();
    if (round || step < kStationStep_m) continue;
    points.push_back(middle);
    centreline.half_width_m.push_back(0.5 * (l - r).head<2>().norm());
    centreline.length_m += points.size() > 1 ? step : 0.0;
  }
  auto& points = centreline.points_m;
  while (centreline.closed && points.size() > 4 &&
         (points.back() - points.front()).head<2>().norm() < 0.5 * kStationStep_m) {
    points.pop_back();
    centreline.half_width_m.pop_back();
  }
  return centreline;
}

}  // namespace road
