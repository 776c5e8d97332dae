// How every fit of this library is solved.
#pragma once

#include <ceres/ceres.h>
#include <ceres/normal_prior.h>

namespace identify {

/// Levenberg and Marquardt within bounds (K. Levenberg 1944, D. W. Marquardt 1963), silent, with
/// sums in one order: the same bytes everywhere.
inline ceres::Solver::Options one_thread(int most_rounds) {
  ceres::Solver::Options out;
  out.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  out.max_num_iterations = most_rounds;
  out.num_threads = 1;
  out.logging_type = ceres::SILENT;
  return out;
}

}  // namespace identify
