#include "strip_ends.h"

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

}  // namespace road
