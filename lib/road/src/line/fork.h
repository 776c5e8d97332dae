// Where another road leaves the way on one side: a pit lane, an escape road, a junction. Private to
// trace_centreline.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/answer.h"
#include "mesh/ray_surface.h"
#include "road/road_graph.h"
#include "stations.h"

namespace road {

struct Fork {
  Eigen::Vector3d point_m;   ///< on the way, about where the surface divides
  Eigen::Vector2d beside_m;  ///< on the other road, two widths further
};

/// Of closed ways apart from each other one that could be the road as well as the first: says where
/// both are. Nothing where the others are shorter or of another width.
std::optional<std::string> two_alike(const std::vector<RoadWay>& ways);

/// Of ways that share branches and are about as long as the longest, the one that is widest where
/// they differ: a pit lane on the outside of a circuit is longer than the road, and narrower. Else
/// the longest. A refusal where another one is about as long and as wide. `ways` as road_ways()
/// gives them, the longest first.
base::Answer<RoadWay> main_way(const RoadGraph& graph, const std::vector<RoadWay>& ways);

/// Whether every station lies on the way; a walk may have taken the other road at a fork.
bool keeps_to(const Walk& walk, const RoadWay& way, double cell_m);

/// The places where a branch that the way does not lead over joins it.
std::vector<Fork> forks_of(const RoadGraph& graph, const RoadWay& way);

/// Stretches of a walk, as indices of stations: `begin` may be after `end` where a closed walk's
/// seam lies between.
struct Stretch {
  std::size_t begin = 0, end = 0;
};

/// Through each fork the edge opposite to the other road tells where the walk's middle is, with the
/// widths before and after. Gives back the stretches that were moved. Where the road is wide for
/// longer than 20 times its width, or another fork lies on the other side, nothing is moved.
std::vector<Stretch> hold_through_forks(const RaySurface& surface, const RoadWay& way,
                                        const std::vector<Fork>& forks, Walk& walk);

/// A way over the surface's roads that goes on in the middle of its own road through every fork.
RoadWay straight_through_forks(const RaySurface& surface, const RoadGraph& graph, RoadWay way);

}  // namespace road
