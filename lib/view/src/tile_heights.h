// How far the points of a tile lie over a road. Private to lib/view.
#pragma once

#include <array>
#include <string>

#include "crg/surface.h"

namespace view {

/// Where the places of a tile stand in a file of points (docs/formats.md, points.tiles), the
/// numbers as the request spells them.
struct TilePlace {
  std::string begin;   ///< byte of the tile's first place
  std::string points;  ///< how many it has
  std::array<double, 3> origin_m{};
};

/// Height of each point less that of the road below or above it, as float32, little endian; NaN:
/// no road lies there, whatever its file says of heights beside its grid. Throws Refusal where the
/// file has no such points.
std::string heights_over(const crg::Surface& road, const std::string& tiles_path,
                         const TilePlace& place);

}  // namespace view
