// The medial axis of a surface of cells, and the graph that it is. Private to road_graph.
#pragma once

#include <vector>

#include "road/road_graph.h"
#include "surface_cells.h"

namespace road {

/// Cells of the medial axis: what is left when cells are taken away from the border inwards as long
/// as that changes neither what is connected nor an end.
std::vector<char> skeleton(const Cells& grid, const std::vector<double>& distance_m);

/// Chains of skeleton cells between ends and forks.
RoadGraph chains(const Cells& grid, const std::vector<double>& distance_m,
                 const std::vector<char>& left);

}  // namespace road
