// Every road of a mesh, not only the one that is taken. Private.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "road/clean.h"
#include "road/road_graph.h"

namespace road {

struct Roads {
  RoadGraph graph;
  Mesh surface;
};

/// What names call road, or colour plainly shows where they call nothing so, and what looks like
/// road by its shape, as far as the options let names count; those without any road left out.
std::vector<Roads> roads_of(const Mesh& mesh, const CleanOptions& options);

/// A strip of the ground, and a place on it.
struct RoadStrip {
  Eigen::Vector2d place_m;
  double width_m;
};

/// The strips that shape alone shows, about as long as the longest, the likeliest road first. With
/// its place as near_m of the options each of them is the road.
std::vector<RoadStrip> strips_that_may_be_road(const Mesh& mesh, const CleanOptions& options);

}  // namespace road
