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
  left_.reserve(4 * flat.triangles.size());
  for (std::uint32_t t = 0; t < flat.triangles.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      left_.try_emplace(directed(flat.triangles[t][c], flat.triangles[t][(c + 1) % 3]), t);
    }
  }
  first_.assign(flat.vertices_m.size() + 1, 0);
  std::vector<std::uint64_t> pairs;
  pairs.reserve(2 * left_.size());
  for (const Triangle& t : flat.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      pairs.push_back(directed(t[c], t[(c + 1) % 3]));
      pairs.push_back(directed(t[(c + 1) % 3], t[c]));
    }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  joined_.reserve(pairs.size());
  for (const std::uint64_t pair : pairs) {
    ++first_[(pair >> 32) + 1];
    joined_.push_back(static_cast<std::uint32_t>(pair));
  }
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
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
  for (std::uint32_t i = first_[v]; i < first_[v + 1]; ++i) {
    if (joined_[i] == u) continue;
    const double angle = std::abs(turn(u, v, joined_[i]));
    if (angle < best) {
      best = angle;
      on = joined_[i];
    }
  }
  return on;
}

}  // namespace road
