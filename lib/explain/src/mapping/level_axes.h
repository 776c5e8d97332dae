// Which axes of a place lie level: games have y upwards. Private.
#pragma once

#include <vector>

#include "explain/mapping.h"
#include "path_fit.h"

namespace explain {

/// Where x_m and y_m, whose unit is not known, are 10, 100 or 1000 times what a column of speed
/// says, takes them for dm, cm or mm. Where x_m and z_m, not x_m and y_m, go as fast as a column of
/// speed says, exchanges y_m and z_m, takes that column for vx_mps, and leaves out what is mapped
/// of the car's axes: their order is not known then. `t` in s. Does nothing where no column of
/// speed decides.
void settle_level_axes(const recording::Table& table, const std::vector<double>& t,
                       Mapping& mapping);

/// Velocities that together are as fast as the path, and x alone is not, lie along the axes of the
/// plane: no channels of the car. So do accelerations beside them that the path does not confirm.
void leave_out_axes_of_plane(const recording::Table& table, const Path& path,
                             const std::vector<double>& lateral, Mapping& mapping);

}  // namespace explain
