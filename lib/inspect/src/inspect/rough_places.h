// Where a file leaves its mesh, and why.
#pragma once

#include <vector>

#include "crg/surface.h"
#include "inspect/validate.h"
#include "mesh/ray_surface.h"

namespace road {

struct RoughPoint {
  double u_m, v_m, error_m;  ///< file - mesh
};

/// The file's height less the mesh's at (u, v); nothing where either is missing.
std::optional<double> error_at(const crg::Surface& road, const RaySurface& mesh,
                               const ValidateOptions& options, double u_m, double v_m);

/// Whether the file closes a crack of the mesh at (u, v), where it has a height and the mesh has
/// none: see sides_of_crack().
bool is_over_crack(const crg::Surface& road, const RaySurface& mesh, const ValidateOptions& options,
                   double u_m, double v_m);

/// Stretches of `known` points, of those found in cells where the nodes' heights bend, and of those
/// in the middle of any cell of the rows half a metre apart.
std::vector<RoughPlace> find_rough_places(const crg::Surface& road, const RaySurface& mesh,
                                          const ValidateOptions& options,
                                          std::vector<RoughPoint> known);

}  // namespace road
