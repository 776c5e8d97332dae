// The borders of the road surface along a walk. Private to trace_centreline.
#pragma once

#include <utility>
#include <vector>

#include "border_curve.h"
#include "mesh/mesh.h"
#include "stations.h"

namespace road {

/// How far each station lies along the walk, in metres; one more value than stations where the walk
/// is closed: its length.
std::vector<double> places_along(const Walk& walk);

/// Vertices on the border of the road surface, as left and right edge, ordered along the walk.
/// A mesh is exact at its vertices and cuts corners between them, so edges are taken from these.
std::pair<std::vector<BorderPoint>, std::vector<BorderPoint>> borders_along(
    const Mesh& mesh, const Walk& walk, const std::vector<double>& station_s_m);

}  // namespace road
