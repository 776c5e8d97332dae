// Every road of a mesh, not only the one that is taken. Private.
#pragma once

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

}  // namespace road
