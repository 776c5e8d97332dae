// How the base runs into what was measured beside it.
#pragma once

#include "cloud/map.h"

namespace cloud {

/// Nodes without points beside such with points: the base moved by their difference from it, less
/// with the distance. Distances along edges and diagonals of the grid.
void blend(const RoadFrame& frame, const crg::Grid& base, const MapOptions& options,
           MapResult& result);

}  // namespace cloud
