// Holes of a mesh that one or two triangles would close. Private to cleaning.
#pragma once

#include <vector>

#include "clean_soup.h"
#include "mesh/mesh.h"

namespace road {

/// Longest side of such a hole.
constexpr double kLargestCornerHole_m = 30.0;

/// Closes holes of the road between three or four corners of the surface: its border tells what is
/// missing there, as where an export has lost a triangle. Larger ones stay, and those with other
/// triangles of the mesh at every edge (an island, a shaft). A triangle at the rim of the surface
/// counts where another one of the mesh has its third edge (a wall, ground beyond). The new
/// triangles take class and object from across their edges; `facts` counts them, and a remark says
/// where. Faces must look up; `flat` tells of every triangle of the mesh whether it could be driven
/// on.
void close_corner_holes(const Mesh& mesh, const std::vector<bool>& flat, Soup& soup,
                        const CleanOptions& options, CleanReport& facts);

}  // namespace road
