// Which axes of a place lie level: games have y upwards. Private.
#pragma once

#include <vector>

#include "explain/mapping.h"

namespace explain {

/// Where x_m and y_m, whose unit is not known, are 10, 100 or 1000 times what a column of speed
/// says, takes them for dm, cm or mm. Where x_m and z_m, not x_m and y_m, go as fast as a column of
/// speed says, exchanges y_m and z_m, takes that column for vx_mps, and leaves out what is mapped
/// of the car's axes: their order is not known then. `t` in s. Does nothing where no column of
/// speed decides.
void settle_level_axes(const recording::Table& table, const std::vector<double>& t,
                       Mapping& mapping);

}  // namespace explain
