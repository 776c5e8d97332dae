// The road of a surface as stations: along a guide, by a walk, or along the graph's way. Private to
// trace_centreline.
#pragma once

#include <optional>

#include "base/answer.h"
#include "mesh/mesh.h"
#include "mesh/ray_surface.h"
#include "road/centreline.h"
#include "road/guide.h"
#include "road/road_graph.h"
#include "stations.h"

namespace road {

/// What the graph shows, as long as it is one closed road and no other beside it. A refusal where
/// it divides into two that are alike.
base::Answer<std::optional<RoadWay>> closed_way(const RoadGraph& graph,
                                                const CentrelineOptions& options);

/// The way along the guide, in the middle of the surface; without width where nothing tells where
/// that is.
RoadWay way_along(const Guide& guide, const RaySurface& surface,
                  std::optional<double> width_m = {});

/// The road of the surface: what lies along the guide; else what a walk finds, unless the graph of
/// the surface shows a closed road that the walk has lost or only a part of which it has found.
base::Answer<Walk> find_road(const Mesh& mesh, const RaySurface& surface, const RoadGraph& graph,
                             const std::optional<Guide>& guide, const CentrelineOptions& options);

}  // namespace road
