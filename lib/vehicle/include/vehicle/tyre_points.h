#pragma once

#include "vehicle/magic_formula.h"
#include "vehicle/table.h"

namespace vehicle {

/// Steady-state forces at every row of `points` (columns fz_n, kappa, alpha_rad, gamma_rad,
/// vx_mps, and pressure_pa where wanted): the same columns followed by fx_n, fy_n, mz_nm, mx_nm,
/// my_nm. Throws Error, with `name` standing for the table, when a column or a cell is missing or a
/// slip angle is a right angle or more.
Table evaluate_tyre(const TyreCoefficients& tyre, const Table& points, const std::string& name,
                    const TyreOptions& options = {});

}  // namespace vehicle
