#include "identify/least_squares.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "one_thread.h"

namespace identify {
namespace {

bool all_finite(const std::vector<double>& left) {
  return std::all_of(left.begin(), left.end(), [](double x) { return std::isfinite(x); });
}

/// All rows as one cost, with slopes by differences.
class Rows : public ceres::CostFunction {
 public:
  Rows(const std::vector<Unknown>& unknowns, const Residuals& residuals, std::size_t count)
      : unknowns_(unknowns), residuals_(residuals), count_(count) {
    set_num_residuals(static_cast<int>(count));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(unknowns.size()));
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const std::size_t n = unknowns_.size();
    std::vector<double> values(parameters[0], parameters[0] + n), left(count_), then(count_),
        before;
    residuals_(values, left);
    if (!all_finite(left)) return false;
    std::copy(left.begin(), left.end(), residuals);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    for (std::size_t k = 0; k < n; ++k) {
      const Unknown& u = unknowns_[k];
      const double at = values[k], h = 1e-6 * u.typical;
      const double to = u.either_way > 0.0 ? std::min(u.high, at + u.either_way)
                                           : at + (at + h > u.high ? -h : h);
      const double from = u.either_way > 0.0 ? std::max(u.low, at - u.either_way) : at;
      values[k] = to;
      residuals_(values, then);
      if (from != at) {
        values[k] = from;
        residuals_(values, before);
      }
      values[k] = at;
      for (std::size_t i = 0; i < count_; ++i)
        jacobians[0][i * n + k] = (then[i] - (from != at ? before : left)[i]) / (to - from);
    }
    return true;
  }

 private:
  const std::vector<Unknown>& unknowns_;
  const Residuals& residuals_;
  std::size_t count_;
};

}  // namespace

LeastSquares least_squares(std::vector<Unknown>& unknowns, const Residuals& residuals,
                           int most_rounds, double settled) {
  std::vector<double> values, left;
  for (const Unknown& u : unknowns) values.push_back(std::clamp(u.value, u.low, u.high));
  residuals(values, left);
  if (!all_finite(left))
    throw base::Error("the fit cannot begin: a row is not finite at the first guess");
  ceres::Problem problem;
  problem.AddResidualBlock(new Rows(unknowns, residuals, left.size()), nullptr, values.data());
  for (std::size_t k = 0; k < unknowns.size(); ++k) {
    problem.SetParameterLowerBound(values.data(), static_cast<int>(k), unknowns[k].low);
    problem.SetParameterUpperBound(values.data(), static_cast<int>(k), unknowns[k].high);
  }
  ceres::Solver::Options options = one_thread(most_rounds);
  options.function_tolerance = settled;
  options.gradient_tolerance = 0.0;  // rows have no common unit
  options.parameter_tolerance = 1e-12;
  options.initial_trust_region_radius = 1e3;
  options.max_num_line_search_step_size_iterations = 0;  // a step is put within the bounds
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  for (std::size_t k = 0; k < unknowns.size(); ++k) unknowns[k].value = values[k];
  LeastSquares out;
  out.rounds = summary.num_successful_steps;
  out.converged = summary.termination_type == ceres::CONVERGENCE;
  out.rms = std::sqrt(2.0 * summary.final_cost /
                      static_cast<double>(std::max<std::size_t>(1, left.size())));
  return out;
}

std::vector<double> linear_fit(const Equation& equation) {
  const auto rows = static_cast<Eigen::Index>(equation.wanted.size());
  Eigen::MatrixXd a(rows, static_cast<Eigen::Index>(equation.columns.size()));
  for (Eigen::Index k = 0; const std::vector<double>& column : equation.columns)
    a.col(k++) = Eigen::Map<const Eigen::VectorXd>(column.data(), rows);
  // A column without effect stays 0 and gets weight 0.
  const Eigen::VectorXd size = a.colwise().norm().transpose().cwiseMax(1e-300);
  const Eigen::VectorXd found =
      (a * size.cwiseInverse().asDiagonal())
          .completeOrthogonalDecomposition()
          .solve(Eigen::Map<const Eigen::VectorXd>(equation.wanted.data(), rows))
          .cwiseQuotient(size);
  return {found.begin(), found.end()};
}

}  // namespace identify
