// Neighbours in a triangle surface: who lies beside an edge, and how a line of edges goes on.
// Private to classify_by_shape.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
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
    if (from == kNoIndex) return kNoIndex;
    const auto found = find(from, to);
    return found == end_of(from) || found->vertex != to ? kNoIndex : found->left;
  }
  /// A number below edges() for each edge, the same from both ends. Precondition: there is one.
  std::size_t edge(std::uint32_t a, std::uint32_t b) const {
    return static_cast<std::size_t>(find(std::min(a, b), std::max(a, b)) - joined_.begin());
  }
  std::size_t edges() const { return joined_.size(); }
  /// Calls use(a, b), a < b, for each edge in the order of both.
  template <class Use>
  void each_edge(Use&& use) const {
    for (std::uint32_t a = 0; a + 1 < first_.size(); ++a)
      for (std::size_t i = first_[a]; i < first_[a + 1]; ++i)
        if (joined_[i].vertex > a) use(a, joined_[i].vertex);
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
  struct Joined {
    std::uint32_t vertex, left;  ///< the triangle on the left of the edge to that vertex
  };
  std::vector<Joined>::const_iterator end_of(std::uint32_t from) const {
    return joined_.begin() + static_cast<std::ptrdiff_t>(first_[from + 1]);
  }
  std::vector<Joined>::const_iterator find(std::uint32_t from, std::uint32_t to) const {
    return std::lower_bound(joined_.begin() + static_cast<std::ptrdiff_t>(first_[from]),
                            end_of(from), to,
                            [](const Joined& l, std::uint32_t v) { return l.vertex < v; });
  }

  const FlatSurface& flat_;
  std::vector<std::size_t> first_;  ///< in joined_, of each vertex and one more
  std::vector<Joined> joined_;      ///< of each vertex by number, each once
};

}  // namespace road
