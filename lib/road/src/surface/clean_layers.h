// Surfaces of a mesh that another one stands for: coarser copies, and undersides. Private to
// cleaning.
#pragma once

#include <string>
#include <vector>

#include "mesh/mesh.h"

namespace road {

/// Triangles that no wheel meets: those of objects called like another one but for a higher level
/// of detail (road_LOD1 beside road_LOD0), and those that look down where the same object has a
/// face that looks up a slab's thickness above most of their piece. Says what was left out in
/// `remarks`.
std::vector<bool> hidden_triangles(const Mesh& mesh, const std::vector<bool>& flat,
                                   std::vector<std::string>& remarks);

}  // namespace road
