#include "derivatives_along.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd derivative(const MatrixXd& x, double place_m, bool closed) {
  const Index n = x.rows();
  MatrixXd d = MatrixXd::Zero(n, x.cols());
  for (Index k = closed ? 0 : 1; k < (closed ? n : n - 1); ++k)
    d.row(k) = (x.row((k + 1) % n) - x.row((k + n - 1) % n)) / (2 * place_m);
  return d;
}

MatrixXd second_derivative(const MatrixXd& x, double place_m, bool closed) {
  const Index n = x.rows();
  MatrixXd d = MatrixXd::Zero(n, x.cols());
  for (Index k = closed ? 0 : 1; k < (closed ? n : n - 1); ++k)
    d.row(k) = (x.row((k + 1) % n) - 2 * x.row(k) + x.row((k + n - 1) % n)) / (place_m * place_m);
  return d;
}

}  // namespace explain
