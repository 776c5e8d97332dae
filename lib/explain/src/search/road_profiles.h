// The road along the whole lap, as sensors alone show it, beside everything that they may get
// wrong.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis.h"

namespace explain {

/// Turns of a wave along the lap.
double wave_turns(std::size_t column, bool closed);

/// Waves along a lap of `places` places: of a closed one whole waves, of an open one half waves.
/// One column per wave, `columns` in all, the first is constant 1; waves have the amplitude 1.
Eigen::MatrixXd waves(std::size_t places, std::size_t columns, bool closed);

/// Places with their 90 % intervals, stretches where it is more than its interval and than what
/// matters, and the largest amount.
void describe_profile(Finding& f, const Unknown& u, const Accepted& a,
                      const Eigen::VectorXd& amounts, const Eigen::MatrixXd& covariance,
                      double length_m, bool closed);

/// What the profile is at its places: shapes times amounts.
std::vector<double> values_along(const Accepted& profile);

}  // namespace explain
