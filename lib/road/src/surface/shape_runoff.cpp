#include "shape_runoff.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <unordered_map>
#include <utility>

namespace road {
namespace {

// Farther from the road than this nothing is called its run-off.
constexpr double kWidestRunoff_m = 25.0;

// A piece of run-off has its outer edge along the inner one (cosine), and its sides across it.
constexpr double kAlong = 0.94;
constexpr double kAcross = 0.75;

using Front = std::pair<std::uint32_t, std::uint32_t>;

/// Points along the sides of the road, in a grid: how far is a triangle from the road?
class RoadSides {
 public:
  RoadSides(const FlatSurface& flat, const Fans& fans, const std::vector<char>& mark) {
    for (std::uint32_t t = 0; t < flat.triangles.size(); ++t) {
      if (mark[t] != 1) continue;
      const Triangle& v = flat.triangles[t];
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t p = v[c], q = v[(c + 1) % 3];
        const std::uint32_t across = fans.left(q, p);
        if (across != kNoIndex && mark[across] == 1) continue;
        open_.emplace_back(p, q);
        const Eigen::Vector3d& a = flat.vertices_m[p];
        const Eigen::Vector3d step = flat.vertices_m[q] - a;
        const int pieces = 1 + static_cast<int>(step.norm() / 3.0);
        for (int k = 0; k < pieces; ++k) {
          const Eigen::Vector3d point = a + step * ((k + 0.5) / pieces);
          points_[key_of(cell_of(point.x()), cell_of(point.y()))].push_back(point);
        }
      }
    }
  }

  /// Edges of the road with no road beside them, the road on their left.
  const std::vector<Front>& open() const { return open_; }

  bool near(const Eigen::Vector3d& point) const {
    for (std::int64_t x = cell_of(point.x()) - 1; x <= cell_of(point.x()) + 1; ++x) {
      for (std::int64_t y = cell_of(point.y()) - 1; y <= cell_of(point.y()) + 1; ++y) {
        const auto found = points_.find(key_of(x, y));
        if (found == points_.end()) continue;
        for (const Eigen::Vector3d& side : found->second) {
          if ((side - point).head<2>().squaredNorm() < kWidestRunoff_m * kWidestRunoff_m)
            return true;
        }
      }
    }
    return false;
  }

 private:
  static std::int64_t cell_of(double value) {
    return static_cast<std::int64_t>(std::floor(value / kWidestRunoff_m));
  }
  static std::uint64_t key_of(std::int64_t x, std::int64_t y) {
    return static_cast<std::uint64_t>(x) << 32 ^ static_cast<std::uint32_t>(y);
  }
  std::unordered_map<std::uint64_t, std::vector<Eigen::Vector3d>> points_;
  std::vector<Front> open_;
};

bool walled(const FlatSurface& flat, std::uint32_t p, std::uint32_t q) {
  return std::binary_search(flat.walls.begin(), flat.walls.end(), undirected(p, q));
}

/// Is p, q, y, x (x beside p, y beside q) a piece of a loft: x-y runs like p-q, p-x and q-y across?
bool lofted(const FlatSurface& flat, const RoadSides& sides, std::uint32_t p, std::uint32_t q,
            std::uint32_t x, std::uint32_t y) {
  const auto at = [&](std::uint32_t v) { return Eigen::Vector2d(flat.vertices_m[v].head<2>()); };
  const Eigen::Vector2d inner = at(q) - at(p), outer = at(y) - at(x), px = at(x) - at(p),
                        qy = at(y) - at(q);
  const double ratio = outer.norm() / inner.norm();
  return ratio > 0.1 && ratio < 10.0 && outer.dot(inner) > kAlong * outer.norm() * inner.norm() &&
         std::abs(px.dot(inner)) < kAcross * px.norm() * inner.norm() &&
         std::abs(qy.dot(inner)) < kAcross * qy.norm() * inner.norm() &&
         sides.near(flat.vertices_m[x]) && sides.near(flat.vertices_m[y]);
}

/// What is left over between lofted pieces: the triangle where a strip begins or ends.
void mark_enclosed(const FlatSurface& flat, const Fans& fans, std::vector<char>& mark) {
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<std::uint32_t> enclosed;
    for (std::uint32_t t = 0; t < flat.triangles.size(); ++t) {
      if (mark[t] != 0) continue;
      int sides_marked = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t p = flat.triangles[t][c], q = flat.triangles[t][(c + 1) % 3];
        const std::uint32_t across = fans.left(q, p);
        sides_marked += across != kNoIndex && mark[across] != 0 && !walled(flat, p, q) ? 1 : 0;
      }
      if (sides_marked >= 2) enclosed.push_back(t);
    }
    for (const std::uint32_t t : enclosed) mark[t] = 2;
  }
}

}  // namespace

void grow_runoff(const FlatSurface& flat, const Fans& fans, std::vector<char>& mark) {
  const RoadSides sides(flat, fans, mark);
  std::deque<Front> fronts(sides.open().begin(), sides.open().end());
  while (!fronts.empty()) {
    const auto [p, q] = fronts.front();
    fronts.pop_front();
    const std::uint32_t t = fans.left(q, p);
    if (t == kNoIndex || mark[t] != 0 || walled(flat, p, q)) continue;
    const std::uint32_t x = fans.apex(t, q, p);
    // The second triangle of the quad lies across q-x or across p-x.
    const std::uint32_t by_q = walled(flat, q, x) ? kNoIndex : fans.left(q, x);
    const std::uint32_t by_p = walled(flat, p, x) ? kNoIndex : fans.left(x, p);
    for (const bool across_q : {true, false}) {
      const std::uint32_t second = across_q ? by_q : by_p;
      if (second == kNoIndex || mark[second] != 0) continue;
      const std::uint32_t y = across_q ? fans.apex(second, q, x) : fans.apex(second, x, p);
      const std::uint32_t beside_p = across_q ? x : y;
      const std::uint32_t beside_q = across_q ? y : x;
      if (!lofted(flat, sides, p, q, beside_p, beside_q)) continue;
      const std::uint32_t behind = fans.left(p, q);
      if (behind != kNoIndex && normal_of(flat, behind).dot(normal_of(flat, t)) < kHill) continue;
      mark[t] = mark[second] = 2;
      fronts.emplace_back(beside_p, beside_q);
      break;
    }
  }
  mark_enclosed(flat, fans, mark);
}

}  // namespace road
