// Places where cells changed together.
#pragma once

#include <vector>

#include "cloud/changes.h"

namespace cloud {

/// Neighbouring cells that changed the same way, the most certain first.
std::vector<ChangePlace> places_of(const std::vector<ChangeCell>& cells, double cell_m,
                                   double min_change_m);

/// Median over the cells: what a place of two cells must change by to be told nine times of ten.
double smallest_told_m(const std::vector<ChangeCell>& cells, double min_change_m);

}  // namespace cloud
