// Walls whose foot the mesh's ground leaves out.
#pragma once

#include "crg/reference_line.h"
#include "road/mesh.h"
#include "road/sample.h"

namespace road {

/// Ends each row at a wall. A mesh often has its ground in front of a wall and behind it, but not below: a gap as narrow
/// as those that sampling fills, so that the file would have even ground through the wall and a place behind it that
/// nobody reaches. From such a gap outwards the nodes of the row lose their heights.
///
/// A gap is a wall's when something of `everything` (the whole mesh, in the frame of the grid) stands 0.05 to 3 m above a
/// node in it, but not also half a metre beside it on both sides (that is a tree, a bridge or a gantry), and when not both
/// nodes beside it are road: across the road itself nothing ends. Changes nodes_with_z, filled and holes of `report` and sets its walls.
void end_at_walls(SampledGrid& sampled, const crg::ReferenceLine& line, const Mesh& everything, unsigned threads,
                  SampleReport& report);

}  // namespace road
