#include "identify/clustered_fit.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Sums of squares and products of one equation, of each block and, the last, of all.
struct Sums {
  std::vector<MatrixXd> normal;
  std::vector<VectorXd> right;
};

MatrixXd scaled_columns(const Equation& e, VectorXd& size) {
  const auto n = static_cast<Index>(e.columns.size()), rows = static_cast<Index>(e.wanted.size());
  MatrixXd a(rows, n);
  size.resize(n);
  for (Index k = 0; k < n; ++k) {
    a.col(k) = Eigen::Map<const VectorXd>(e.columns[static_cast<std::size_t>(k)].data(), rows);
    size(k) = std::max(1e-300, a.col(k).norm());
    a.col(k) /= size(k);
  }
  return a;
}

Sums sums_of(const Equation& e, const MatrixXd& a, const std::vector<std::size_t>& block,
             std::size_t blocks) {
  const Index n = a.cols();
  Sums out;
  out.normal.assign(blocks + 1, MatrixXd::Zero(n, n));
  out.right.assign(blocks + 1, VectorXd::Zero(n));
  for (Index r = 0; r < a.rows(); ++r) {
    const auto row = static_cast<std::size_t>(r);
    out.normal[block[row]] += a.row(r).transpose() * a.row(r);
    out.right[block[row]] += e.wanted[row] * a.row(r).transpose();
  }
  for (std::size_t b = 0; b < blocks; ++b) {
    out.normal[blocks] += out.normal[b];
    out.right[blocks] += out.right[b];
  }
  return out;
}

/// A refusal where the columns cannot be told apart.
base::Answer<VectorXd> solve(const MatrixXd& normal, const VectorXd& right) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> e(normal);
  const VectorXd& lambda = e.eigenvalues();
  if (!(lambda(0) > 1e-12 * lambda(lambda.size() - 1)))
    return base::Refusal(
        "what is asked for cannot be told apart: the recording does not vary enough, or only at "
        "one place; wanted more of the lap, at other speeds");
  return VectorXd(e.eigenvectors() * (e.eigenvectors().transpose() * right).cwiseQuotient(lambda));
}

}  // namespace

double ClusteredFit::sd(std::size_t k) const { return std::sqrt(covariance[k * value.size() + k]); }

double ClusteredFit::sd_of(const std::vector<double>& slope) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < value.size(); ++i)
    for (std::size_t j = 0; j < value.size(); ++j)
      sum += slope[i] * slope[j] * covariance[i * value.size() + j];
  return std::sqrt(std::max(0.0, sum));
}

base::Answer<ClusteredFit> clustered_fit(const std::vector<Equation>& equations,
                                         const std::vector<std::size_t>& block) {
  std::vector<std::size_t> names = block;  // blocks without a row do not count
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  std::vector<std::size_t> place(block.size());
  for (std::size_t r = 0; r < block.size(); ++r)
    place[r] = static_cast<std::size_t>(std::lower_bound(names.begin(), names.end(), block[r]) -
                                        names.begin());
  ClusteredFit out;
  out.blocks = names.size();
  Index size = 0;
  for (const Equation& e : equations) {
    if (out.blocks < e.columns.size() + 2)
      return base::Refusal(fmt::format(
          "{} places or stretches of the drive remain, {} numbers are asked for: wanted at least "
          "{}; give a longer drive",
          out.blocks, e.columns.size(), e.columns.size() + 2));
    size += static_cast<Index>(e.columns.size());
  }
  VectorXd value(size);
  MatrixXd without(size, static_cast<Index>(out.blocks));
  Index first = 0;
  for (const Equation& e : equations) {
    VectorXd scale;
    const MatrixXd a = scaled_columns(e, scale);
    const Sums sums = sums_of(e, a, place, out.blocks);
    const auto solved = solve(sums.normal.back(), sums.right.back());
    if (!solved) return solved.refusal();
    const VectorXd& found = *solved;
    const auto wanted =
        Eigen::Map<const VectorXd>(e.wanted.data(), static_cast<Index>(e.wanted.size()));
    out.rms.push_back(
        std::sqrt((wanted - a * found).squaredNorm() / static_cast<double>(e.wanted.size())));
    value.segment(first, a.cols()) = found.cwiseQuotient(scale);
    for (std::size_t b = 0; b < out.blocks; ++b) {
      const auto left =
          solve(sums.normal.back() - sums.normal[b], sums.right.back() - sums.right[b]);
      if (!left) return left.refusal();
      without.col(static_cast<Index>(b)).segment(first, a.cols()) = left->cwiseQuotient(scale);
    }
    first += a.cols();
  }
  const MatrixXd off = without.colwise() - value;
  const auto g = static_cast<double>(out.blocks);
  const MatrixXd covariance = (g - 1.0) / g * off * off.transpose();
  out.value.assign(value.data(), value.data() + size);
  out.covariance.assign(covariance.data(), covariance.data() + size * size);
  return out;
}

}  // namespace identify
