// What sampling leaves open: cracks too thin to be a hole, and gaps in which a wall stands.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "crg/reference_line.h"
#include "mesh/mesh.h"
#include "mesh/ray_surface.h"
#include "road/road_mesh.h"
#include "road/sample.h"

namespace road {

/// Where a surface goes on within 3.5 cm on two opposite sides of a place that it misses, `across`
/// (length 1) or along, at heights that differ by at most 2 cm and lie within 10 cm of the place's;
/// nothing when that is no crack.
std::optional<std::array<SurfaceHit, 2>> sides_of_crack(const RaySurface& surface,
                                                        const Eigen::Vector3d& at_m,
                                                        const Eigen::Vector2d& across);

/// Nodes without a height between others of their row get one where they fell into a crack:
/// sides_of_crack() in `surface` (that of `road`), near the row's height. They count as filled, of
/// the class of the one side; unlike sampling's own filling this also closes cracks between road
/// and kerb or run-off. Changes nodes_with_z, filled and holes of `report`.
void close_cracks(SampledGrid& sampled, const RaySurface& surface, const RoadMesh& road,
                  const crg::ReferenceLine& line, SampleReport& report);

/// Counts again what has a height: nodes_with_z, filled and holes of `report`.
void count_nodes(const SampledGrid& sampled, SampleReport& report);

/// Ends each row at a wall. A mesh often has its ground in front of a wall and behind it, but not
/// below: a gap as narrow as those that sampling fills, so that the file would have even ground
/// through the wall and a place behind it that nobody reaches. From such a gap outwards the nodes
/// of the row lose their heights.
///
/// A gap is a wall's when something of `everything` (the whole mesh, in the frame of the grid)
/// stands 0.05 to 3 m above a node in it, but not also half a metre beside it on both sides (that
/// is a tree, a bridge or a gantry), and when not both nodes beside it are road: across the road
/// itself nothing ends. Changes nodes_with_z, filled and holes of `report` and sets its walls.
void end_at_walls(SampledGrid& sampled, const crg::ReferenceLine& line, const Mesh& everything,
                  unsigned threads, SampleReport& report);

}  // namespace road
