// A way over the roads of a surface, told by a few points. Private to clean.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/answer.h"
#include "road/guide.h"
#include "road/road_graph.h"

namespace road {

/// The shortest way over the graph's roads through the points, in their order; closed when the last
/// is the first. No road is used twice, but crossings are. Each point stands for the nearest place
/// on a road. A refusal names the two points between which there is no way, or the one that is far
/// from every road.
base::Answer<RoadWay> way_through(const RoadGraph& graph,
                                  const std::vector<Eigen::Vector2d>& points_m);

/// A way as a guide: a point each width of the road, the steps of the graph's cells smoothed. A
/// refusal where it is hardly longer than wide.
base::Answer<Guide> guide_of(const RoadWay& way);

/// As few points of a way as tell it from every other: way_through() gives the way again (a length
/// within 3 %). Closed ways end with their first point. Empty when more than 16 are needed.
std::vector<Eigen::Vector2d> points_that_tell(const RoadGraph& graph, const RoadWay& way);

}  // namespace road
