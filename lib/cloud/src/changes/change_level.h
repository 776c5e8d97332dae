// Differences between campaigns that are no change: the points' scatter, and what is even over a
// width.
#pragma once

#include <vector>

#include "cloud/changes.h"

namespace cloud {

/// A dozen points may scatter little by chance: no cell's points count as better than half of those
/// around do. Cells that scatter ten times as much show no surface (cars that passed): they go,
/// and are counted in `unclear`. `points`: that count, of each cell.
void share_scatter(std::vector<ChangeCell>& cells, const std::vector<double>& points, double cell_m,
                   std::size_t& unclear);

/// Takes out of the cells what is even over level_m; scales their deviations. Says how much in the
/// result.
void take_level_out(std::vector<ChangeCell>& cells, double level_m, ChangeResult& result);

}  // namespace cloud
