// Surfaces of a mesh that another one stands for (coarser copies, undersides), and marks that stick
// out of the road. Private to cleaning.
#pragma once

#include <string>
#include <vector>

#include "mesh/mesh.h"
#include "road/clean.h"

namespace road {

/// Triangles that no wheel meets: those of objects called like another one but for a higher level
/// of detail (road_LOD1 beside road_LOD0), and those that look down where the same object has a
/// face that looks up a slab's thickness above most of their piece. Says what was left out in
/// `remarks`.
std::vector<bool> hidden_triangles(const Mesh& mesh, const std::vector<bool>& flat,
                                   const std::vector<SurfaceClass>& class_of_object,
                                   std::vector<std::string>& remarks);

/// Marks drawn across gaps of the road, under its name, and wider than it (sectors, a start): what
/// lies in a gap stays road, what sticks out of it becomes scenery. Otherwise the middle of the
/// road would follow the mark to both sides.
void cut_strokes(const Mesh& mesh, const std::vector<bool>& flat, const CleanOptions& options,
                 std::vector<SurfaceClass>& class_of_triangle, CleanReport& facts);

}  // namespace road
