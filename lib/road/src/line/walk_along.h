// Stations along a way that the graph of a surface shows. Private to trace_centreline.
#pragma once

#include "road/road_graph.h"
#include "stations.h"

namespace road {

/// Where one edge lies much farther out than elsewhere (a fork, a crossing) or nearer (a hole), the
/// other edge and the usual width tell where the middle is; in a gap, the way itself does. An open
/// way goes on to the end of its surface (`to_the_end`), or ends where it ends. What is usual is
/// the way's own width where it `knows_widths`, else what the places around say.
Walk walk_along(const RaySurface& surface, const RoadWay& way, bool to_the_end = true,
                bool knows_widths = false);

}  // namespace road
