// A graph of roads without what only the cells put into it. Private to road_graph.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "road/road_graph.h"

namespace road {

/// Tells every node its branches.
void list_branches(RoadGraph& graph);

/// The same branch, driven the other way.
RoadBranch reversed(RoadBranch branch);

/// Leaves out dead ends no longer than the road is wide: they lead into corners.
void prune(RoadGraph& graph);

/// Forks whose discs hold each other's middle are one: a crossing is seen as two forks.
void merge_near_forks(RoadGraph& graph);

/// The last stretch of a dead end, where the axis runs into a corner or the surface narrows, is
/// left out.
void trim_ends(RoadGraph& graph);

/// Direction in which a branch leaves its node, over about the road's width.
Eigen::Vector2d leaving(const RoadGraph& graph, std::uint32_t b, bool forwards);

}  // namespace road
