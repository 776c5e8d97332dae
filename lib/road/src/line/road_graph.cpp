#include "road/road_graph.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <utility>

#include "base/statistics.h"
#include "skeleton.h"
#include "surface_cells.h"
#include "tidy_graph.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kCells = 60'000;  // of the whole surface, more where the road is narrow
constexpr double kMostCells = 1'500'000;
constexpr double kCellsAcross = 8.0;
constexpr double kHeadroom_m = 1.5;
constexpr double kLongestGapWidths = 12.0;
constexpr double kFacing = 0.8;  // cosine between the direction of an end and the gap

/// Joins dead ends that face each other by branches without surface.
void add_gaps(const Cells& grid, RoadGraph& graph) {
  struct End {
    std::uint32_t node;
    Vector2d outwards;
  };
  std::vector<End> ends;
  for (std::uint32_t v = 0; v < graph.nodes.size(); ++v) {
    if (graph.nodes[v].branches.size() != 1) continue;
    const std::uint32_t b = graph.nodes[v].branches[0];
    ends.push_back({v, -leaving(graph, b, graph.branches[b].from == v)});
  }
  std::vector<std::tuple<double, std::uint32_t, std::uint32_t>> pairs;
  for (std::uint32_t i = 0; i < ends.size(); ++i) {
    for (std::uint32_t j = i + 1; j < ends.size(); ++j) {
      const RoadNode &p = graph.nodes[ends[i].node], &q = graph.nodes[ends[j].node];
      const Vector2d across = (q.point_m - p.point_m).head<2>();
      const double length_m = across.norm();
      if (length_m <= 0.0 || length_m > kLongestGapWidths * (p.half_width_m + q.half_width_m))
        continue;
      if (std::min(ends[i].outwards.dot(across), -ends[j].outwards.dot(across)) <
          kFacing * length_m)
        continue;
      if (std::abs(p.point_m.z() - q.point_m.z()) > 0.5 * length_m) continue;
      if (std::max(p.half_width_m, q.half_width_m) > 2.0 * std::min(p.half_width_m, q.half_width_m))
        continue;
      pairs.emplace_back(length_m, i, j);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<char> used(ends.size(), 0);
  for (const auto& [length_m, i, j] : pairs) {
    if (used[i] || used[j]) continue;
    used[i] = used[j] = 1;
    const RoadNode &p = graph.nodes[ends[i].node], &q = graph.nodes[ends[j].node];
    RoadBranch gap;
    gap.from = ends[i].node;
    gap.to = ends[j].node;
    gap.length_m = length_m;
    gap.is_gap = true;
    const auto steps = static_cast<int>(std::ceil(length_m / grid.cell_m()));
    for (int k = 0; k <= steps; ++k) {
      const double t = static_cast<double>(k) / steps;
      gap.points_m.push_back((1.0 - t) * p.point_m + t * q.point_m);
      gap.half_width_m.push_back((1.0 - t) * p.half_width_m + t * q.half_width_m);
      if (!grid.has_surface_at(gap.points_m.back())) gap.gap_m += length_m / (steps + 1);
    }
    graph.branches.push_back(std::move(gap));
  }
  list_branches(graph);
}

/// Half of a strip's cells lie farther from its border than a quarter of its width.
double width_by_distances_m(const std::vector<double>& distance_m) {
  return 4.0 * base::median(distance_m);
}

}  // namespace

RoadGraph road_graph(const Mesh& surface) {
  double area_m2 = 0.0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Vector3d a = surface.vertex(t, 1) - surface.vertex(t, 0),
                   b = surface.vertex(t, 2) - surface.vertex(t, 0);
    area_m2 += 0.5 * std::abs(a.x() * b.y() - a.y() * b.x());
  }
  if (!(area_m2 > 0.0)) return {};
  double cell_m = std::sqrt(area_m2 / kCells), headroom_m = 0.0;
  while (true) {
    Cells grid(surface, cell_m, headroom_m);
    const double width_m = width_by_distances_m(distances_m(grid));
    if (headroom_m == 0.0) {
      headroom_m = std::min(kHeadroom_m, 0.25 * width_m);
      continue;
    }
    const double wanted_m = std::max(width_m / kCellsAcross, std::sqrt(area_m2 / kMostCells));
    if (cell_m > 1.2 * wanted_m) {
      cell_m = wanted_m;
      continue;
    }
    grid.fill_holes(width_m * width_m);
    const std::vector<double> distance_m = distances_m(grid);
    RoadGraph graph = chains(grid, distance_m, skeleton(grid, distance_m));
    graph.area_m2 = static_cast<double>(grid.cells.size()) * cell_m * cell_m;
    prune(graph);
    merge_near_forks(graph);
    prune(graph);
    trim_ends(graph);
    add_gaps(grid, graph);
    return graph;
  }
}

}  // namespace road
