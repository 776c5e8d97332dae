// Which control points agree with each other. Private to the alignment.
#pragma once

#include <vector>

#include "point_fits.h"

namespace road {

/// Least median of squares (Rousseeuw 1984) over the smallest sets, then least squares over what
/// agrees with it.
base::Answer<Indices> inliers(const std::vector<ControlPoint>& points, const AlignOptions& options);

}  // namespace road
