// Derivatives along a road of what is known at places that are equally far apart; 0 at both ends of
// an open one.
#pragma once

#include <Eigen/Core>

namespace explain {

Eigen::VectorXd derivative(const Eigen::VectorXd& x, double place_m, bool closed);
Eigen::VectorXd second_derivative(const Eigen::VectorXd& x, double place_m, bool closed);

/// Rows times the matrix of second_derivative().
Eigen::MatrixXd times_second_derivative(Eigen::MatrixXd rows, double place_m, bool closed);

}  // namespace explain
