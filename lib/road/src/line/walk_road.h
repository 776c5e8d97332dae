// Finds the road by walking on its surface. Private to trace_centreline.
#pragma once

#include <string>

#include "base/answer.h"
#include "mesh/mesh.h"
#include "road/centreline.h"
#include "stations.h"

namespace road {

/// The longest loop that walks from many places on the surface find, or else the longest open road.
/// A refusal when none finds a strip, or when there are two. A walk can lose a road that the
/// graph of the surface shows (road_graph.h): hairpins without an inner radius, wide places.
base::Answer<Walk> walk_road(const Mesh& mesh, const RaySurface& surface,
                             const CentrelineOptions& options);

/// "a loop of 500 m through x = 1.0, y = 2.0".
std::string describe(const Walk& walk);

}  // namespace road
