// Long lines of edges on a surface: the sides of roads, and the lines along them. Private to
// classify_by_shape.
#pragma once

#include <cstdint>
#include <vector>

#include "fans.h"

namespace road {

// A chain along the track outlives anything that runs across it (60 m with run-off on both sides).
inline constexpr double kShortestChain_m = 120.0;
inline constexpr std::size_t kFewestChainEdges = 8;

struct Chain {
  std::vector<std::uint32_t> vertices;  ///< when closed, the first is not repeated
  bool closed = false;
  double length_m = 0.0;
  std::size_t edges() const { return vertices.size() - (closed ? 0 : 1); }
  std::uint32_t at(std::size_t i) const { return vertices[i % vertices.size()]; }
};

std::vector<Chain> long_chains(const FlatSurface& flat, const Fans& fans,
                               double shortest_m = kShortestChain_m,
                               std::size_t fewest_edges = kFewestChainEdges);

/// Mean angle between the surfaces on both sides of a chain.
double fold_along(const FlatSurface& flat, const Fans& fans, const Chain& chain);

/// Do both sides of a chain fall away alike, as those of a crowned road from its middle?
bool is_crest(const FlatSurface& flat, const Fans& fans, const Chain& chain);

}  // namespace road
