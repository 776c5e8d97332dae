// A few unknowns of a formula from many rows.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "identify/clustered_fit.h"

namespace identify {

struct Unknown {
  std::string name;
  double value = 0.0;            ///< where the search begins, and what it found
  double low = 0.0, high = 0.0;  ///< never left
  double typical = 1.0;          ///< size of the unknown: differences are 1e-6 of it
  double either_way = 0.0;       ///< differences to both sides, so far; 0: to one side
};

struct LeastSquares {
  double rms = 0.0;  ///< root mean square of what is left
  int rounds = 0;
  bool converged = false;  ///< the last round took less than `settled` of the sum away
};

/// Fills `left`, always of the same length, with what the values leave of the rows.
using Residuals = std::function<void(const std::vector<double>& values, std::vector<double>& left)>;

/// Levenberg and Marquardt within bounds (K. Levenberg 1944, D. W. Marquardt 1963) by Ceres, slopes
/// by differences. Moves `unknowns` to the least sum of squares near where they begin. Throws
/// base::Error when the begin leaves something that is not finite.
LeastSquares least_squares(std::vector<Unknown>& unknowns, const Residuals& residuals,
                           int most_rounds = 60, double settled = 1e-6);

/// Weights of an equation's columns by least squares. A column without effect gets weight 0.
std::vector<double> linear_fit(const Equation& equation);

}  // namespace identify
