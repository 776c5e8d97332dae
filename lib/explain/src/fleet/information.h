// Sums of a drive as matrices.
#pragma once

#include <Eigen/Core>

#include "explain/summary.h"

namespace explain {

/// X'X with all that is zero between knots that are no neighbours.
Eigen::MatrixXd whole_matrix(const Information& sums, const DriveSummary& of);

}  // namespace explain
