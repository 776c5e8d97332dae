#include "fans.h"

#include <Eigen/Geometry>
#include <array>
#include <numbers>

namespace road {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

}  // namespace

Eigen::Vector3d normal_of(const FlatSurface& flat, std::uint32_t t) {
  const Triangle& v = flat.triangles[t];
  return (flat.vertices_m[v[1]] - flat.vertices_m[v[0]])
      .cross(flat.vertices_m[v[2]] - flat.vertices_m[v[0]])
      .normalized();
}

Fans::Fans(const FlatSurface& flat) : flat_(flat) {
  const std::size_t vertices = flat.vertices_m.size();
  first_.assign(vertices + 1, 0);
  for (const Triangle& t : flat.triangles)
    for (const std::uint32_t v : t) first_[v + 1] += 2;
  for (std::size_t v = 0; v < vertices; ++v) first_[v + 1] += first_[v];
  joined_.resize(first_[vertices]);
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t t = 0; t < flat.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t a = flat.triangles[t][c], b = flat.triangles[t][(c + 1) % 3];
      joined_[next[a]++] = {b, t};
      joined_[next[b]++] = {a, kNoIndex};
    }
  // Of several triangles on the left of an edge the first.
  std::size_t kept = 0;
  for (std::size_t v = 0; v < vertices; ++v) {
    const auto begin = joined_.begin() + static_cast<std::ptrdiff_t>(first_[v]),
               end = joined_.begin() + static_cast<std::ptrdiff_t>(first_[v + 1]);
    std::sort(begin, end, [](const Joined& l, const Joined& r) {
      return l.vertex != r.vertex ? l.vertex < r.vertex : l.left < r.left;
    });
    first_[v] = kept;
    for (auto at = begin; at != end; ++at)
      if (at == begin || at->vertex != joined_[kept - 1].vertex) joined_[kept++] = *at;
  }
  first_[vertices] = kept;
  joined_.resize(kept);
}

std::uint32_t Fans::straight_on(std::uint32_t u, std::uint32_t v) const {
  constexpr double kSharpest = 60.0 * kDegree;
  constexpr double kSharpestElsewhere = 25.0 * kDegree;
  std::array<std::uint32_t, 2> third{kNoIndex, kNoIndex};
  std::array<bool, 2> border{false, false};
  for (std::size_t side = 0; side < 2; ++side) {
    std::uint32_t w = u;
    int passed = 0;
    for (; passed < 3; ++passed) {
      const std::uint32_t t = side == 0 ? left(w, v) : left(v, w);
      if (t == kNoIndex) break;
      w = apex(t, w, v);
    }
    if (passed == 3) third[side] = w;
    border[side] = passed == 0;
  }
  std::uint32_t on = kNoIndex;
  if (third[0] != kNoIndex && (third[0] == third[1] || border[1])) on = third[0];
  if (third[1] != kNoIndex && border[0]) on = third[1];
  if (on != kNoIndex && std::abs(turn(u, v, on)) < kSharpest) return on;
  double best = kSharpestElsewhere;
  on = kNoIndex;
  for (std::size_t i = first_[v]; i < first_[v + 1]; ++i) {
    if (joined_[i].vertex == u) continue;
    const double angle = std::abs(turn(u, v, joined_[i].vertex));
    if (angle < best) {
      best = angle;
      on = joined_[i].vertex;
    }
  }
  return on;
}

}  // namespace road
