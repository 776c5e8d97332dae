// Is the road that was found the road that is there?
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mesh/ray_surface.h"
#include "road/centreline.h"
#include "road/clean.h"

namespace road {

/// What speaks against a traced line, each a sentence with the place and a way out; empty when
/// nothing does.
///
/// Looked at: surface missing along the line, more than 5 % of it; more than 1.6 times the usual
/// width along more than 1 % of it, but where the mesh draws it as one strip from border to border;
/// another surface of the mesh 0.03 to 2.5 m above it, along more than 30 %; and where no name told
/// what is road: names of what nobody drives on (water, a roof), a strip at
/// the rim of flat ground, an open road that is less than half of the flat ground, and more of the
/// material of the road elsewhere than a fifth of what was found. Along a guide or a route: what
/// cleaning doubted there. `surface` holds the triangles of `road`, `mesh` everything that was
/// read, `report` what cleaning said.
std::vector<std::string> doubts_about(const Centreline& line, const RaySurface& surface,
                                      const Mesh& road, const Mesh& mesh,
                                      const CleanReport& report);

/// That more of the material of the road lies elsewhere than a fifth of what was found, with a
/// place: the line may be a part of the road only. Empty where that is not so, and where materials
/// tell nothing apart.
std::optional<std::string> same_material_elsewhere(const Centreline& line, const Mesh& mesh,
                                                   const CleanReport& report);

}  // namespace road
