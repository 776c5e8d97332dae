// A road as variables of MATLAB.
#pragma once

#include <string>

#include "crg/surface.h"

namespace road {

/// A MAT file of level 5, not packed, little endian. Of each row x_m, y_m and heading_rad of the
/// reference line; v_m of each column; z_m(row, column), the height in the map frame with banking,
/// NaN where there is no road; u_begin_m, u_step_m, closed (0 or 1). All are doubles. Throws Error
/// where z_m would have 2 GB.
std::string matlab_file(const crg::Surface& road);

}  // namespace road
