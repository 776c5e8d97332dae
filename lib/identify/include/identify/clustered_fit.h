// Linear least squares whose errors come in blocks, with standard deviations that stay right.
#pragma once

#include <cstddef>
#include <vector>

#include "base/answer.h"

namespace identify {

/// One equation: columns[k][row] times its weight, summed over k, is wanted[row].
struct Equation {
  std::vector<std::vector<double>> columns;
  std::vector<double> wanted;
};

/// Weights of all equations one behind the other.
struct ClusteredFit {
  std::vector<double> value;
  std::vector<double> covariance;  ///< size * size, row by row
  std::vector<double> rms;         ///< what each equation leaves, root mean square
  std::size_t blocks = 0;

  double sd(std::size_t k) const;
  /// Standard deviation of the sum of slope[k] * value[k].
  double sd_of(const std::vector<double>& slope) const;
};

/// Least squares of each equation by itself; all share their rows, and row r belongs to block[r].
/// The covariance is that of the jackknife that leaves out one block at a time (M. H. Quenouille
/// 1956, J. W. Tukey 1958): errors within a block may follow each other as they like. A refusal
/// with less than two blocks more than there are columns in an equation, or where the
/// columns cannot be told apart (condition of the scaled columns above 1e6) with any block left
/// out.
base::Answer<ClusteredFit> clustered_fit(const std::vector<Equation>& equations,
                                         const std::vector<std::size_t>& block);

/// How many standard deviations make a 90 % interval with `freedom` degrees of it: the quantile of
/// Student's t at 95 % by its expansion (M. Abramowitz, I. A. Stegun, Handbook of Mathematical
/// Functions, 26.7.5), within 0.3 % from 3 on.
double t90(double freedom);

inline constexpr double kNormal90 = 1.645;  ///< the same of the normal distribution

/// Half of the 90 % interval of a number that comes from a drive and from the car's file: the
/// standard deviations of what each leaves open, the drive's with `freedom` degrees of freedom.
double half_width_90(double freedom, double sd_drive, double sd_file);

}  // namespace identify
