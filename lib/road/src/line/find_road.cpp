#include "find_road.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/statistics.h"
#include "fork.h"
#include "guide_rows.h"
#include "walk_along.h"
#include "walk_road.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kShortestLoopWidths = 10.0;  // a shorter loop is a traffic island

constexpr double kLostShare =
    1.2;  // the graph's ways are 3 to 6 % too long: their cells make steps

constexpr double kSecondWay = 0.3;  // of the longest way: a shorter one is a branch

/// The one way of a graph that has no second one to speak of.
std::optional<RoadWay> only_way(const RoadGraph& graph) {
  const std::vector<RoadWay> ways = road_ways(graph, 0.0, 2);
  if (ways.empty() || (ways.size() > 1 && ways[1].length_m > kSecondWay * ways[0].length_m))
    return std::nullopt;
  const double width_m = 2.0 * base::median(ways[0].half_width_m);
  if (width_m < kMinWidth_m || width_m > kMaxWidth_m ||
      ways[0].length_m < kShortestLoopWidths * width_m)
    return std::nullopt;
  return ways[0];
}

}  // namespace

base::Answer<std::optional<RoadWay>> closed_way(const RoadGraph& graph,
                                                const CentrelineOptions& options) {
  std::vector<RoadWay> ways = road_ways(graph, kGapAlong_m);
  std::erase_if(ways, [](const RoadWay& way) {
    const double width_m = 2.0 * base::median(way.half_width_m);
    return !way.closed || width_m < kMinWidth_m || width_m > kMaxWidth_m ||
           way.length_m < kShortestLoopWidths * width_m;
  });
  const auto distance_m = [&](const RoadWay& way) {
    double best = std::numeric_limits<double>::infinity();
    for (const Vector3d& p : way.points_m)
      best = std::min(best, (p.head<2>() - *options.start_near_m).norm());
    return best;
  };
  const auto together = [](const RoadWay& a, const RoadWay& b) {
    return std::find_first_of(a.branches.begin(), a.branches.end(), b.branches.begin(),
                              b.branches.end()) != a.branches.end();
  };
  if (ways.empty()) return std::optional<RoadWay>{};
  if (options.start_near_m) {
    const RoadWay nearest = *std::min_element(
        ways.begin(), ways.end(),
        [&](const RoadWay& a, const RoadWay& b) { return distance_m(a) < distance_m(b); });
    std::erase_if(ways, [&](const RoadWay& way) { return !together(way, nearest); });
  }
  if (const auto alike = two_alike(ways))
    return base::Refusal(*alike + "; choose one with --start-at X,Y (recipe: start_near_m)");
  for (std::size_t i = 1; i < ways.size(); ++i)
    if (!together(ways[0], ways[i]) && ways[i].length_m > 0.5 * ways[0].length_m)
      return std::optional<RoadWay>{};
  auto way = main_way(graph, ways);
  if (!way) return way.refusal();
  return std::optional<RoadWay>(*std::move(way));
}

RoadWay way_along(const Guide& guide, const RaySurface& surface, std::optional<double> width_m) {
  GuideRows all = rows_along(guide, surface, [](std::uint32_t) { return true; });
  if (width_m && all.usual_half_m > 0.0) set_width(all, *width_m);
  RoadWay way;
  way.closed = all.closed;
  for (const GuideRow& row : all.rows) {
    const Vector2d p = row.at_m + row.middle_m * left_of(row.heading);
    way.points_m.emplace_back(p.x(), p.y(), row.z_m);
    way.half_width_m.push_back(row.half_width_m);
  }
  return way;
}

base::Answer<Walk> find_road(const Mesh& mesh, const RaySurface& surface, const RoadGraph& graph,
                             const std::optional<Guide>& guide, const CentrelineOptions& options) {
  if (guide) {
    const RoadWay way = way_along(*guide, surface, options.guide_width_m);
    if (base::median(way.half_width_m) == 0.0)
      return base::Refusal(
          "nothing on the surface along the guide tells where the road ends; say how wide it is "
          "(--guide-width-m W, guide_width_m in a recipe)");
    return walk_along(surface, way, false, true);
  }
  const auto way = closed_way(graph, options);
  if (!way) return way.refusal();
  auto walk = walk_road(mesh, surface, options);
  if (!*way) {
    if (walk) return walk;
    const std::optional<RoadWay> only = only_way(graph);
    return only ? walk_along(surface, *only) : std::move(walk);
  }
  if (walk && walk->closed && (*way)->length_m < kLostShare * walk->length_m &&
      (forks_of(graph, **way).empty() || keeps_to(*walk, **way, graph.cell_m)))
    return walk;
  return walk_along(surface, **way);  // the graph knows better
}

}  // namespace road
