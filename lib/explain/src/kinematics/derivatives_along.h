// Derivatives along a road of what is known at places that are equally far apart; 0 at both ends of
// an open one.
#pragma once

#include <Eigen/Core>

namespace explain {

/// Of each column.
Eigen::MatrixXd derivative(const Eigen::MatrixXd& x, double place_m, bool closed);
Eigen::MatrixXd second_derivative(const Eigen::MatrixXd& x, double place_m, bool closed);

}  // namespace explain
