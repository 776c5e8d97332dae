// The road surface as a graph: which roads there are, how long and how wide, and where they fork.
// Private to trace_centreline.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "mesh/mesh.h"

namespace road {

/// A road between two nodes, or a ring (from == to).
struct RoadBranch {
  std::uint32_t from = 0, to = 0;
  std::vector<Eigen::Vector3d> points_m;  ///< map coordinates, from `from` to `to`, a cell apart
  std::vector<double> half_width_m;       ///< to the nearest border, for each point
  double length_m = 0.0;
  bool is_gap = false;  ///< straight from one end to another that faces it
  double gap_m = 0.0;   ///< length without surface
};

struct RoadNode {
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  double half_width_m = 0.0;
  std::vector<std::uint32_t> branches;  ///< a ring's twice
};

struct RoadGraph {
  std::vector<RoadNode> nodes;
  std::vector<RoadBranch> branches;
  double cell_m = 0.0;   ///< how fine the surface was looked at: places are good to this
  double area_m2 = 0.0;  ///< of the surface in plan, coplanar doubles counted once
};

/// The medial axis of a surface in plan, layer by layer: a bridge and the road below it are not
/// joined. Cells are a part of the surface's size, so that a model circuit and a pass road are seen
/// alike; cracks, T-junctions and doubled triangles narrower than a cell do not count. Branches
/// that only lead into a corner of the surface are left out.
RoadGraph road_graph(const Mesh& surface);

/// A way through the graph.
struct RoadWay {
  std::vector<Eigen::Vector3d> points_m;
  std::vector<double> half_width_m;
  std::vector<std::uint32_t> branches;
  bool closed = false;
  double length_m = 0.0;
  double gap_m = 0.0;
};

/// The `most` longest closed ways without a sharp turn; where there are none, the longest open
/// ones, from end to end. Ends of roads that face each other over at most `longest_gap_m` are
/// joined. No branch is used twice; a crossing may be passed twice, straight on.
std::vector<RoadWay> road_ways(const RoadGraph& graph, double longest_gap_m, std::size_t most = 12);

}  // namespace road
