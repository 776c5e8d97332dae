#include "identify/least_squares.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace identify {
namespace {

double sum_of_squares(const std::vector<double>& left) {
  double sum = 0.0;
  for (const double x : left) sum += x * x;
  return sum;
}

/// J^T J and J^T r at `values`, which leave `left`.
void slopes(const std::vector<Unknown>& unknowns, const Residuals& residuals,
            const std::vector<double>& values, const std::vector<double>& left,
            Eigen::MatrixXd& normal, Eigen::VectorXd& gradient) {
  const auto n = static_cast<Eigen::Index>(unknowns.size());
  Eigen::MatrixXd jacobian(static_cast<Eigen::Index>(left.size()), n);
  std::vector<double> moved = values, then(left.size());
  for (std::size_t k = 0; k < unknowns.size(); ++k) {
    double h = 1e-6 * unknowns[k].typical;
    if (values[k] + h > unknowns[k].high) h = -h;
    moved[k] = values[k] + h;
    residuals(moved, then);
    moved[k] = values[k];
    for (std::size_t i = 0; i < left.size(); ++i)
      jacobian(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          (then[i] - left[i]) / h;
  }
  normal = jacobian.transpose() * jacobian;
  gradient = jacobian.transpose() *
             Eigen::Map<const Eigen::VectorXd>(left.data(), static_cast<Eigen::Index>(left.size()));
}

}  // namespace

LeastSquares least_squares(std::vector<Unknown>& unknowns, const Residuals& residuals,
                           int most_rounds) {
  LeastSquares out;
  std::vector<double> values, left;
  for (const Unknown& u : unknowns) values.push_back(std::clamp(u.value, u.low, u.high));
  residuals(values, left);
  double sum = sum_of_squares(left), damping = 1e-3;
  if (!std::isfinite(sum))
    throw base::Error("the fit cannot begin: a row is not finite at the first guess");
  Eigen::MatrixXd normal;
  Eigen::VectorXd gradient;
  for (; out.rounds < most_rounds && !out.converged; ++out.rounds) {
    slopes(unknowns, residuals, values, left, normal, gradient);
    bool better = false;
    while (!better && damping < 1e12) {
      Eigen::MatrixXd damped = normal;
      for (Eigen::Index k = 0; k < damped.rows(); ++k)
        damped(k, k) += damping * normal(k, k) + 1e-300;
      const Eigen::VectorXd step = damped.ldlt().solve(-gradient);
      std::vector<double> next = values, then;
      for (std::size_t k = 0; k < next.size(); ++k)
        next[k] = std::clamp(values[k] + step(static_cast<Eigen::Index>(k)), unknowns[k].low,
                             unknowns[k].high);
      residuals(next, then);
      const double sum_then = sum_of_squares(then);
      better = std::isfinite(sum_then) && sum_then < sum;
      if (better) {
        out.converged = sum - sum_then < 1e-6 * sum;
        sum = sum_then;
        values = next;
        left = then;
      }
      damping = better ? std::max(1e-9, 0.2 * damping) : 5.0 * damping;
    }
    if (!better) out.converged = true;  // no step lowers it
  }
  for (std::size_t k = 0; k < unknowns.size(); ++k) unknowns[k].value = values[k];
  out.rms = std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, left.size())));
  return out;
}

std::vector<double> linear_fit(const std::vector<std::vector<double>>& columns,
                               const std::vector<double>& wanted) {
  const auto rows = static_cast<Eigen::Index>(wanted.size());
  Eigen::MatrixXd a(rows, static_cast<Eigen::Index>(columns.size()));
  Eigen::VectorXd size(static_cast<Eigen::Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    a.col(column) = Eigen::Map<const Eigen::VectorXd>(columns[k].data(), rows);
    size(column) = a.col(column).norm();
    if (size(column) > 0.0) a.col(column) /= size(column);
  }
  const Eigen::VectorXd found = a.completeOrthogonalDecomposition().solve(
      Eigen::Map<const Eigen::VectorXd>(wanted.data(), rows));
  std::vector<double> out(columns.size(), 0.0);
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    if (size(column) > 0.0) out[k] = found(column) / size(column);
  }
  return out;
}

}  // namespace identify
