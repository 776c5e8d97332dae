#include "middles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// The other edge's point opposite to point i of `from`: the chord makes equal angles with both
/// edges.
std::optional<Vector3d> opposite(const BorderCurve& from, std::size_t i, const BorderCurve& to) {
  const Vector2d p = from[i].point.head<2>();
  const Vector2d& tangent = from.tangent(i);
  const auto off = [&](const std::pair<Vector3d, Vector2d>& q) {
    return (q.first.head<2>() - p).dot(tangent + q.second);
  };
  std::size_t segment = to.segment_of(from[i].s_m);
  // Walk to the segment that holds the sign change.
  for (int tries = 0; tries < 40; ++tries) {
    const double at_begin = off(to.at(segment, 0.0)), at_end = off(to.at(segment, 1.0));
    if (at_begin > 1e-9) {
      if (segment == 0 && to.segments() < to.size()) return std::nullopt;
      segment = segment == 0 ? to.segments() - 1 : segment - 1;
      if (off(to.at(segment, 0.0)) <= 1e-9 && off(to.at(segment, 1.0)) < -1e-9) return std::nullopt;
    } else if (at_end < -1e-9) {
      if (segment + 1 == to.segments() && to.segments() < to.size()) return std::nullopt;
      segment = segment + 1 == to.segments() ? 0 : segment + 1;
      if (off(to.at(segment, 0.0)) > 1e-9) return std::nullopt;
    } else {
      double lo = 0.0, hi = 1.0;
      for (int k = 0; k < 50; ++k) {
        const double t = 0.5 * (lo + hi);
        (off(to.at(segment, t)) < 0.0 ? lo : hi) = t;
      }
      return to.at(segment, 0.5 * (lo + hi)).first;
    }
  }
  return std::nullopt;
}

std::vector<Middle> middles_of(const RaySurface& surface, const Walk& walk, const BorderCurve& left,
                               const BorderCurve& right) {
  std::vector<Middle> middles;
  const double typical_half_m = 0.5 * walk.area_m2 / std::max(walk.length_m, 1.0);
  for (const bool from_left : {true, false}) {
    const BorderCurve &from = from_left ? left : right, &to = from_left ? right : left;
    for (std::size_t i = 0; i < from.size(); ++i) {
      const auto other = opposite(from, i, to);
      if (!other) continue;
      const Vector3d middle = 0.5 * (from[i].point + *other);
      const double half_m = 0.5 * (from[i].point - *other).head<2>().norm();
      if (half_m > 3.0 * typical_half_m + 2.0) continue;
      const auto hit = surface.nearest_hit(middle.x(), middle.y(), middle.z(), 2.0 * kLayerReach_m);
      middles.push_back(
          {from[i].s_m, {middle.x(), middle.y(), hit ? hit->z_m : middle.z()}, half_m});
    }
  }
  return middles;
}

/// Sorts middles along the road and merges those that stand for the same cross-section.
std::vector<Middle> ordered(std::vector<Middle> middles, const Walk& walk,
                            const std::vector<double>& station_s_m) {
  // s of an edge point is not the s of its middle: project the middle on the walk.
  const std::size_t n = walk.stations.size();
  const std::size_t segments = walk.closed ? n : n - 1;
  for (Middle& m : middles) {
    const auto near = static_cast<std::size_t>(
        std::upper_bound(station_s_m.begin(), station_s_m.end(), m.s_m) - station_s_m.begin());
    double best_m = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 25; ++k) {
      std::size_t i = near + n + k - 13;
      if (walk.closed) {
        i %= n;
      } else if (i < n || i >= n + segments) {
        continue;
      } else {
        i -= n;
      }
      const Vector2d a = walk.stations[i].centre.head<2>(),
                     b = walk.stations[(i + 1) % n].centre.head<2>();
      const double t = std::clamp(
          (m.point.head<2>() - a).dot(b - a) / std::max((b - a).squaredNorm(), 1e-12), 0.0, 1.0);
      const double d = (m.point.head<2>() - (a + t * (b - a))).norm();
      if (d < best_m) {
        best_m = d;
        m.s_m = station_s_m[i] + t * (station_s_m[i + 1] - station_s_m[i]);
      }
    }
  }
  std::sort(middles.begin(), middles.end(), [](const Middle& a, const Middle& b) {
    return std::tie(a.s_m, a.point.x(), a.point.y()) < std::tie(b.s_m, b.point.x(), b.point.y());
  });
  std::vector<Middle> result;
  double weight = 1.0;
  for (const Middle& m : middles) {
    if (!result.empty() && m.s_m - result.back().s_m < 0.5) {
      Middle& last = result.back();
      weight += 1.0;
      last.point += (m.point - last.point) / weight;
      last.half_width_m += (m.half_width_m - last.half_width_m) / weight;
      last.s_m += (m.s_m - last.s_m) / weight;
    } else {
      result.push_back(m);
      weight = 1.0;
    }
  }
  return result;
}

}  // namespace

std::vector<Middle> middles_between(const RaySurface& surface, const Walk& walk,
                                    const BorderCurve& left, const BorderCurve& right,
                                    const std::vector<double>& station_s_m) {
  return ordered(middles_of(surface, walk, left, right), walk, station_s_m);
}

bool agrees(const Middle& middle, const Walk& walk, const std::vector<double>& station_s_m,
            double unlike) {
  const std::size_t n = walk.stations.size();
  const auto after = static_cast<std::size_t>(
      std::upper_bound(station_s_m.begin(), station_s_m.end(), middle.s_m) - station_s_m.begin());
  const std::size_t b = std::min(after, station_s_m.size() - 1), a = b == 0 ? 0 : b - 1;
  const double t =
      b == a ? 0.0
             : (middle.s_m - station_s_m[a]) / std::max(station_s_m[b] - station_s_m[a], 1e-9);
  const Station &from = walk.stations[a], &to = walk.stations[b % n];
  const Vector2d place = from.centre.head<2>() + t * (to.centre - from.centre).head<2>();
  const double half_m = 0.5 * (from.width_m() + t * (to.width_m() - from.width_m()));
  return (middle.point.head<2>() - place).norm() < unlike * half_m &&
         std::abs(middle.half_width_m - half_m) < unlike * half_m;
}

}  // namespace road
