#include "window_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd weights_of(const VectorXd& e) {
  std::vector<double> size(static_cast<std::size_t>(e.size()));
  for (Index i = 0; i < e.size(); ++i) size[static_cast<std::size_t>(i)] = std::abs(e[i]);
  const auto middle = size.begin() + static_cast<std::ptrdiff_t>(size.size() / 2);
  std::nth_element(size.begin(), middle, size.end());
  const double sigma = std::max(1e-5, 1.4826 * *middle);
  const VectorXd c = e.cwiseMax(-3 * sigma).cwiseMin(3 * sigma);
  const double variance = c.squaredNorm() / static_cast<double>(c.size());
  double spread = 1.0;
  constexpr Index kLags = 6;
  for (Index lag = 1; lag <= std::min(kLags, c.size() - 1); ++lag)
    spread += 2 * (1 - static_cast<double>(lag) / static_cast<double>(kLags + 1)) *
              c.tail(c.size() - lag).dot(c.head(c.size() - lag)) / c.squaredNorm();
  const double sd = std::sqrt(variance * std::clamp(spread, 1.0, 10.0));
  return (3 * sigma / e.cwiseAbs().cwiseMax(1e-300).array()).min(1.0) / sd;
}

Solved solve(const MatrixXd& x, const VectorXd& y, const VectorXd& weight, const VectorXd& prior) {
  const MatrixXd a = weight.asDiagonal() * x;
  MatrixXd normal = a.transpose() * a;
  const VectorXd right = a.transpose() * weight.cwiseProduct(y);
  normal.diagonal() += prior;
  const Eigen::LLT<MatrixXd> solver(normal);
  Solved out;
  out.amount = solver.solve(right);
  out.covariance = solver.solve(MatrixXd::Identity(x.cols(), x.cols()));
  out.evidence = 0.5 * right.dot(out.amount) - solver.matrixLLT().diagonal().array().log().sum() +
                 0.5 * prior.array().log().sum();
  return out;
}

VectorXd left_out(const MatrixXd& x, const VectorXd& y, const VectorXd& weight,
                  const VectorXd& prior, const TurningWindows& w) {
  VectorXd out(y.size());
  for (int k = 0; k < w.folds; ++k) {
    VectorXd others = weight;
    for (Index i = 0; i < y.size(); ++i)
      if (w.fold[static_cast<std::size_t>(i)] == k) others[i] = 0.0;
    const VectorXd e = y - x * solve(x, y, others, prior).amount;
    for (Index i = 0; i < y.size(); ++i)
      if (w.fold[static_cast<std::size_t>(i)] == k) out[i] = e[i];
  }
  return out;
}

}  // namespace explain
