// Every road of a mesh, not only the one that is taken. Private.
#pragma once

#include <vector>

#include "road/clean.h"
#include "road_graph.h"

namespace road {

/// What names call road, and what looks like road by its shape, as far as the options let names
/// count; each as a graph, those without any road left out.
std::vector<RoadGraph> roads_of(const Mesh& mesh, const CleanOptions& options);

}  // namespace road
