// Windows of recordings as rows of a linear problem, weighed by what is left of them.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "turning_windows.h"

namespace explain {

/// Weights, 1 / standard deviation, by residuals `e`: spread by the median; outliers count as three
/// standard deviations; errors that go on over windows count as few.
Eigen::VectorXd weights_of(const Eigen::VectorXd& e);

/// Rows times amounts make y. `prior`: 1 / variance of each amount.
struct Solved {
  Eigen::VectorXd amount;
  Eigen::MatrixXd covariance;
  double evidence = 0.0;  ///< logarithm, less a constant
};
Solved solve(const Eigen::MatrixXd& x, const Eigen::VectorXd& y, const Eigen::VectorXd& weight,
             const Eigen::VectorXd& prior);

/// Rows that are not linear: fills what amounts make of them, and its slopes where these are asked
/// for.
using Makes = std::function<void(const Eigen::VectorXd& amount, Eigen::VectorXd& made,
                                 Eigen::MatrixXd* slopes)>;
struct Settled {
  Eigen::VectorXd amount;
  double loss = 0.0;
};
/// From `begin` to the least loss near it, by Ceres: what is left of y and what amounts are from
/// `centre`, squared over variances; of a row that is further than three standard deviations, six
/// times as many, less nine.
Settled settle(const Eigen::VectorXd& y, const Eigen::VectorXd& weight, Eigen::VectorXd begin,
               const Eigen::VectorXd& centre, const Eigen::VectorXd& prior, int rounds,
               const Makes& makes);

/// What is left of each half lap where the others say what is there.
Eigen::VectorXd left_out(const Eigen::MatrixXd& x, const Eigen::VectorXd& y,
                         const Eigen::VectorXd& weight, const Eigen::VectorXd& prior,
                         const TurningWindows& w);

}  // namespace explain
