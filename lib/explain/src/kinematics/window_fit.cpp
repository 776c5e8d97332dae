#include "window_fit.h"

#include <ceres/tiny_solver.h>

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

namespace {

/// Rows and amounts as Ceres sees them.
struct Left {
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = Eigen::Dynamic };
  const VectorXd &y, &weight, &centre;
  VectorXd firm;  ///< 1 / standard deviation of each amount
  const Makes& makes;

  int NumResiduals() const { return static_cast<int>(y.size() + firm.size()); }
  int NumParameters() const { return static_cast<int>(firm.size()); }
  bool operator()(const double* amounts, double* left, double* slopes) const {
    const Eigen::Map<const VectorXd> amount(amounts, firm.size());
    VectorXd made;
    MatrixXd by;
    makes(amount, made, slopes != nullptr ? &by : nullptr);
    constexpr double kFar = 3;
    const Eigen::ArrayXd e = weight.cwiseProduct(y - made),
                         far = (kFar * (2 * e.abs() - kFar)).max(kFar * kFar).sqrt();
    Eigen::Map<VectorXd>(left, NumResiduals())
        << (e.abs() < kFar).select(e, e.sign() * far).matrix(),
        firm.cwiseProduct(amount - centre);
    if (slopes == nullptr) return true;
    const VectorXd turns = -weight.array() * (e.abs() < kFar).select(1, kFar / far);
    Eigen::Map<MatrixXd>(slopes, NumResiduals(), NumParameters()) << turns.asDiagonal() * by,
        MatrixXd(firm.asDiagonal());
    return true;
  }
};

}  // namespace

Settled settle(const VectorXd& y, const VectorXd& weight, VectorXd begin, const VectorXd& centre,
               const VectorXd& prior, int rounds, const Makes& makes) {
  ceres::TinySolver<Left> solver;
  solver.options.max_num_iterations = rounds;
  solver.options.initial_trust_region_radius = 100;
  solver.options.function_tolerance = 1e-3 * static_cast<double>(y.size());  // about one a row
  solver.Solve({y, weight, centre, prior.cwiseSqrt(), makes}, &begin);
  return {begin, 2 * solver.summary.final_cost};
}

}  // namespace explain
