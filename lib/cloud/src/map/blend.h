// How the base runs into what was measured beside it.
#pragma once

#include "cloud/map.h"

namespace cloud {

/// Nodes without points beside such with points: the base moved by their difference from it, less
/// with the distance. Distances along edges and diagonals of the grid. Their deviation, and that of
/// nodes farther away, is how wrong the base was seen to be at the nearest node with points; it
/// fades over as much as a ramp of 1 % needs for that.
void blend(const RoadFrame& frame, const crg::Grid& base, const MapOptions& options,
           MapResult& result);

}  // namespace cloud
