// Virtual telemetry as a table, and what its columns rest on.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "identify/forces.h"
#include "recording/table.h"

namespace identify {

/// Rows that have forces: time_s, u_m, v_m, per wheel fx, fy, fz, kappa, alpha, camber, each with
/// its standard deviation (..._sd_...), vx and tyre temperature of the wheel; per axle fx, fy, fz;
/// speeds, sideslip and steering of the car.
recording::Table forces_table(const Forces& forces);

/// Columns, and what their numbers rest on: what was measured, what is the vehicle file's word and
/// was not observed.
std::vector<std::pair<std::string, std::string>> forces_basis(const Forces& forces);

}  // namespace identify
