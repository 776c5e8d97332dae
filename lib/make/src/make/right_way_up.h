// Is a road the right way up? Private to make.
#pragma once

#include <optional>
#include <string>

#include "mesh/ray_surface.h"
#include "mesh/up_axis.h"
#include "road/centreline.h"

namespace road {

/// 1: a road is the right way up, -1: upside down, 0: nothing tells.
struct WayUp {
  int told = 0;    ///< 0, too, where two things contradict each other
  int likely = 0;  ///< then what its bends say
};

/// By what gravity and eyes want of roads: most of it is crowned, its bends are banked inwards, and
/// no other ground lies over it. `road` holds the road alone, `everything` the mesh. Without
/// `everything` nobody looks for other ground.
WayUp right_way_up(const Centreline& line, const RaySurface& road, const RaySurface* everything);

/// What to give where a road found with this axis up is upside down by right_way_up(): its heights
/// may be negated. Empty where it is not.
std::optional<std::string> doubt_about_up(const Centreline& line, const RaySurface& road,
                                          UpAxis up);

}  // namespace road
