// Which side of the ground things are on. Private to the mesh readers.
#pragma once

#include "raw_mesh.h"

namespace road {

/// 1, -1: walls and trees stand on the ground along a line (0, 1, 2 for x, y, z), or against it; 0:
/// nothing tells.
int side_of_things(const RawMesh& mesh, int line);

/// The same of objects that lie on larger ones, closely: a road on its run-off, paint on a road.
/// The other way round nobody would see them.
int side_of_sheets(const RawMesh& mesh, int line);

}  // namespace road
