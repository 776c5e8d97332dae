// Profiles of findings as rows of a road file.
#pragma once

#include <cstddef>
#include <vector>

#include "explain/findings.h"

namespace explain {

/// A profile at every row: a quadratic B-spline over its cells, to nothing outside. Kinks of
/// banking would be bumps under the wheels beside the middle of the road. `profile`: two points at
/// least.
std::vector<double> profile_along(const std::vector<ProfilePoint>& profile, std::size_t rows,
                                  double u_step_m, bool closed);

}  // namespace explain
