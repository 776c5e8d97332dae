#include "derivatives_along.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd derivative(const VectorXd& x, double place_m, bool closed) {
  const Index n = x.size();
  VectorXd d = VectorXd::Zero(n);
  for (Index k = closed ? 0 : 1; k < (closed ? n : n - 1); ++k)
    d[k] = (x[(k + 1) % n] - x[(k + n - 1) % n]) / (2 * place_m);
  return d;
}

VectorXd second_derivative(const VectorXd& x, double place_m, bool closed) {
  const Index n = x.size();
  VectorXd d = VectorXd::Zero(n);
  for (Index k = closed ? 0 : 1; k < (closed ? n : n - 1); ++k)
    d[k] = (x[(k + 1) % n] - 2 * x[k] + x[(k + n - 1) % n]) / (place_m * place_m);
  return d;
}

MatrixXd times_second_derivative(MatrixXd rows, double place_m, bool closed) {
  const Index n = rows.cols();
  if (!closed) rows.col(0).setZero(), rows.col(n - 1).setZero();
  MatrixXd d = -2 * rows;
  for (Index k = 0; k < n; ++k) {
    if (closed || k > 0) d.col(k) += rows.col((k + n - 1) % n);
    if (closed || k + 1 < n) d.col(k) += rows.col((k + 1) % n);
  }
  return d / (place_m * place_m);
}

}  // namespace explain
