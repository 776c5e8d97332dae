// Neighbours in a triangle surface: who lies beside an edge, and how a line of edges goes on.
// Private to classify_by_shape.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "classify_by_shape.h"

namespace road {

/// Upwards where the triangle is seen counter-clockwise.
Eigen::Vector3d normal_of(const FlatSurface& flat, std::uint32_t t);

/// Who lies beside a directed edge, and which vertices a vertex is joined with.
class Fans {
 public:
  explicit Fans(const FlatSurface& flat);

  /// Triangle on the left of from -> to, kNoIndex if none.
  std::uint32_t left(std::uint32_t from, std::uint32_t to) const {
    const auto found = left_.find(directed(from, to));
    return found == left_.end() ? kNoIndex : found->second;
  }
  std::uint32_t apex(std::uint32_t t, std::uint32_t a, std::uint32_t b) const {
    for (const std::uint32_t v : flat_.triangles[t]) {
      if (v != a && v != b) return v;
    }
    return kNoIndex;
  }
  double turn(std::uint32_t u, std::uint32_t v, std::uint32_t w) const {
    const Eigen::Vector2d in = (flat_.vertices_m[v] - flat_.vertices_m[u]).head<2>();
    const Eigen::Vector2d out = (flat_.vertices_m[w] - flat_.vertices_m[v]).head<2>();
    return std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out));
  }

  /// Where a chain of edges that comes from u to v goes on. Inside a loft three triangles lie on
  /// either side of it at every vertex; elsewhere it goes as straight as it can.
  std::uint32_t straight_on(std::uint32_t u, std::uint32_t v) const;

 private:
  const FlatSurface& flat_;
  std::unordered_map<std::uint64_t, std::uint32_t> left_;
  std::vector<std::uint32_t> first_, joined_;
};

}  // namespace road
