// The road along the whole lap, as sensors alone show it, beside everything that they may get
// wrong.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis.h"

namespace explain {

/// Places with their 90 % intervals, stretches where it is more than its interval and than what
/// matters, and the largest amount.
void describe_profile(Finding& f, const Unknown& u, const Accepted& a,
                      const Eigen::VectorXd& amounts, const Eigen::MatrixXd& covariance,
                      double length_m, bool closed);

/// What the profile is at its places: shapes times amounts.
std::vector<double> values_along(const Accepted& profile);

}  // namespace explain
