#pragma once

#include "recording/table.h"
#include "vehicle/magic_formula.h"

namespace vehicle {

/// Steady-state forces at every row of `points` (columns fz_n, kappa, alpha_rad, gamma_rad,
/// vx_mps, and pressure_pa and turn_1pm where wanted): the same columns followed by fx_n, fy_n,
/// mz_nm, mx_nm, my_nm. turn_1pm is the turning of the wheel's plane about the vertical,
/// counter-clockwise, over its speed. Throws Error, with `name` standing for the table, when a
/// column or a cell is missing, a slip angle is a right angle or more, or a tyre is turned whose
/// file has no turn slip.
recording::Table evaluate_tyre(const TyreCoefficients& tyre, const recording::Table& points,
                               const std::string& name, const TyreOptions& options = {});

}  // namespace vehicle
