#include "strip_ends.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

namespace road {

std::vector<End> open_ends(const std::vector<Triangle>& triangles,
                           const std::vector<Eigen::Vector3d>& vertices_m, double widest_m) {
  constexpr double kCorner = 45.0 * std::numbers::pi / 180.0;
  std::vector<End> ends;
  for (const auto& loop : border_loops(triangles, vertices_m)) {
    const std::size_t n = loop.size();
    std::vector<std::size_t> corners;  // where the border turns left: convex corners of the surface
    for (std::size_t i = 0; i < n && n >= 4; ++i) {
      const Eigen::Vector2d in =
          (vertices_m[loop[i]] - vertices_m[loop[(i + n - 1) % n]]).head<2>();
      const Eigen::Vector2d out = (vertices_m[loop[(i + 1) % n]] - vertices_m[loop[i]]).head<2>();
      if (std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out)) > kCorner)
        corners.push_back(i);
    }
    for (std::size_t k = 0; k < corners.size() && corners.size() >= 2; ++k) {
      const std::size_t begin = corners[k];
      const std::size_t end = corners[(k + 1) % corners.size()];
      End candidate;
      double along_m = 0.0;
      for (std::size_t i = begin;; i = (i + 1) % n) {
        candidate.vertices.push_back(loop[i]);
        if (i == end) break;
        along_m += (vertices_m[loop[(i + 1) % n]] - vertices_m[loop[i]]).head<2>().norm();
        if (along_m > widest_m) break;
      }
      candidate.first = vertices_m[loop[begin]];
      candidate.last = vertices_m[loop[end]];
      const Eigen::Vector2d chord = (candidate.last - candidate.first).head<2>();
      candidate.width_m = chord.norm();
      if (along_m > widest_m || candidate.width_m < 2.0 || candidate.width_m < 0.9 * along_m)
        continue;
      candidate.middle = (candidate.first + candidate.last) / 2.0;
      candidate.outward = Eigen::Vector2d(chord.y(), -chord.x()) / candidate.width_m;
      ends.push_back(std::move(candidate));
    }
  }
  return ends;
}

std::vector<Gap> facing_ends(const std::vector<End>& ends, double longest_m) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    for (std::size_t j = i + 1; j < ends.size(); ++j) {
      const Eigen::Vector3d d = ends[j].middle - ends[i].middle;
      const double distance_m = d.head<2>().norm();
      if (distance_m > longest_m || std::abs(d.z()) > 0.01 + 0.1 * distance_m) continue;
      if (ends[i].outward.dot(ends[j].outward) > -0.7) continue;
      // In front of each other, or overlapping a little.
      if (distance_m > 0.25 && d.head<2>().dot(ends[i].outward) < 0.7 * distance_m) continue;
      const double ratio = ends[i].width_m / ends[j].width_m;
      if (ratio < 0.7 || ratio > 1.4) continue;
      pairs.emplace_back(distance_m, i, j);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<bool> used(ends.size(), false);
  std::vector<Gap> gaps;
  for (const auto& [distance_m, i, j] : pairs) {
    if (used[i] || used[j]) continue;
    used[i] = used[j] = true;
    gaps.push_back({ends[i], ends[j], distance_m});
  }
  return gaps;
}

std::vector<std::vector<Eigen::Vector3d>> rows_over(const Gap& gap, const std::vector<EndPoint>& a,
                                                    const std::vector<EndPoint>& b) {
  constexpr double kRow_m = 1.0, kMostTurn = 0.6, kMostKink = 0.1;
  const int rows = static_cast<int>(gap.length_m / kRow_m) - 1;
  if (rows < 3) return {};
  const Eigen::Vector2d over = (gap.b.middle - gap.a.middle).head<2>().normalized();
  const auto angle = [](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    return std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
  };
  // Ends that are cut askew turn against each other, those of a bend alike.
  const double turn = std::clamp(0.5 * (angle(gap.a.outward, over) + angle(over, -gap.b.outward)),
                                 -kMostTurn, kMostTurn);
  const double longer = std::abs(turn) > 1e-6 ? turn / std::sin(turn) : 1.0;
  const auto share = [](const std::vector<EndPoint>& end, const EndPoint& point) {
    const Eigen::Vector2d along = (end.back().at_m - end.front().at_m).head<2>();
    return along.dot((point.at_m - end.front().at_m).head<2>()) / along.squaredNorm();
  };
  std::vector<std::vector<Eigen::Vector3d>> out(static_cast<std::size_t>(rows));
  for (const EndPoint& from : a) {
    const double f = share(a, from);
    std::size_t k = 1;
    while (k + 1 < b.size() && share(b, b[k]) < f) ++k;
    const double f0 = share(b, b[k - 1]), f1 = share(b, b[k]);
    const double w = f1 > f0 ? std::clamp((f - f0) / (f1 - f0), 0.0, 1.0) : 0.0;
    const Eigen::Vector3d to = b[k - 1].at_m + w * (b[k].at_m - b[k - 1].at_m);
    const double to_slope = b[k - 1].slope + w * (b[k].slope - b[k - 1].slope);
    const Eigen::Vector3d way = to - from.at_m;
    const double length_m = longer * way.head<2>().norm(), straight = way.z() / length_m;
    const auto tangent = [&](double by, double slope) {
      const Eigen::Vector2d d = longer * (Eigen::Rotation2Dd(by) * way.head<2>());
      const double z = std::clamp(slope, straight - kMostKink, straight + kMostKink) * length_m;
      return Eigen::Vector3d(d.x(), d.y(), z);
    };
    const Eigen::Vector3d begins = tangent(-turn, from.slope), ends = tangent(turn, to_slope);
    for (int r = 0; r < rows; ++r) {
      const double t = (r + 1.0) / (rows + 1.0);
      out[static_cast<std::size_t>(r)].push_back(from.at_m + t * t * (3.0 - 2.0 * t) * way +
                                                 t * (1.0 - t) * (1.0 - t) * begins -
                                                 t * t * (1.0 - t) * ends);
    }
  }
  return out;
}

}  // namespace road
