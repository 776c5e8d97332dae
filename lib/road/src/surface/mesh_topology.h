// Edges, borders and neighbourhoods of a triangle soup with shared vertices. Private to clean.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace road {

using Triangle = std::array<std::uint32_t, 3>;
inline constexpr std::uint32_t kNoIndex = std::numeric_limits<std::uint32_t>::max();

inline std::uint64_t directed(std::uint32_t from, std::uint32_t to) {
  return static_cast<std::uint64_t>(from) << 32 | to;
}

/// The key of an edge: lower vertex in the upper half, higher vertex in the lower.
inline std::uint64_t undirected(std::uint32_t a, std::uint32_t b) {
  return directed(std::min(a, b), std::max(a, b));
}

/// Disjoint sets; the representative is the smallest member, whatever the order of joins.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count);
  std::uint32_t find(std::uint32_t item);
  std::size_t size() const { return parent_.size(); }
  void join(std::uint32_t a, std::uint32_t b);

 private:
  std::vector<std::uint32_t> parent_;
};

/// For every vertex the lowest vertex that is within `horizontal_m` in plan and within `vertical_m`
/// in height. Chains of near vertices are not followed, so nothing moves farther than that.
std::vector<std::uint32_t> weld(const std::vector<Eigen::Vector3d>& vertices_m, double horizontal_m,
                                double vertical_m);

/// One use of an edge: triangle `t`'s edge from its corner `c` to the next.
struct EdgeUse {
  std::uint64_t key = 0;  ///< undirected()
  std::uint32_t t = 0;
  std::uint8_t c = 0;
};

/// All edge uses sorted by edge, so that the uses of one edge lie together.
std::vector<EdgeUse> edge_uses(const std::vector<Triangle>& triangles);

/// How triangles hang together over shared edges, those where more than two meet among them.
struct Components {
  std::vector<std::uint32_t> of_triangle;  ///< 0 upwards in order of the first triangle
  std::uint32_t count = 0;
  /// The first triangle at each edge where more than two meet, in order.
  std::vector<std::uint32_t> at_non_manifold_edges;
};

/// No triangle may have a vertex twice.
Components components(const std::vector<Triangle>& triangles);

/// Number of connected sets of border edges: 2 for a ring, 1 for an open strip, more with holes.
std::size_t count_borders(const std::vector<Triangle>& triangles);

/// Closed borders of the triangles, surface on the left when faces point up. A vertex where borders
/// touch is passed by the edge that turns least to the right of the surface.
std::vector<std::vector<std::uint32_t>> border_loops(
    const std::vector<Triangle>& triangles, const std::vector<Eigen::Vector3d>& vertices_m);

}  // namespace road
