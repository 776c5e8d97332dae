// Linear least squares whose errors come in blocks, with standard deviations that stay right.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <vector>

#include "base/answer.h"

namespace identify {

/// How many rows count as one where errors follow each other, by the sums of the products of
/// neighbours and of squares.
inline double rows_as_one(double product, double square) {
  const double r = square > 0.0 ? std::clamp(product / square, 0.0, 0.98) : 0.0;
  return (1.0 + r) / (1.0 - r);
}

/// One equation: columns[k][row] times its weight, summed over k, is wanted[row].
struct Equation {
  std::vector<std::vector<double>> columns;
  std::vector<double> wanted;

  /// All rows are as long as the first.
  void add(std::initializer_list<double> row, double is) {
    columns.resize(row.size());
    for (std::size_t k = 0; const double value : row) columns[k++].push_back(value);
    wanted.push_back(is);
  }
};

/// Weights of all equations one behind the other.
struct ClusteredFit {
  std::vector<double> value;
  std::vector<double> covariance;  ///< size * size, row by row
  std::vector<double> rms;         ///< what each equation leaves, root mean square
  std::size_t blocks = 0;

  double sd(std::size_t k) const;
  Eigen::VectorXd values() const {
    return Eigen::Map<const Eigen::VectorXd>(value.data(), static_cast<Eigen::Index>(value.size()));
  }
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

}  // namespace identify
