#include "block_matrix.h"

#include <algorithm>

namespace cloud {

BlockMatrix::BlockMatrix(const std::vector<std::uint32_t>& block_of) {
  std::vector<Eigen::Index> sizes;
  for (const std::uint32_t block : block_of) {
    if (block >= sizes.size()) sizes.resize(block + 1, 0);
    place_.push_back({block, sizes[block]++});
  }
  begin_.assign(1, 0);
  for (const Eigen::Index size : sizes) begin_.push_back(begin_.back() + size);
  columns_.resize(sizes.size());
}

void BlockMatrix::set_zero() {
  for (Column& column : columns_) column.clear();
}

void BlockMatrix::scale(double times) {
  for (Column& column : columns_)
    for (auto& [row, block] : column) block *= times;
}

Eigen::MatrixXd& BlockMatrix::block(std::uint32_t row, std::uint32_t column) {
  Eigen::MatrixXd& found = columns_[column][row];
  if (found.size() == 0)
    found.setZero(begin_[row + 1] - begin_[row], begin_[column + 1] - begin_[column]);
  return found;
}

void BlockMatrix::add(std::size_t row, std::size_t column,
                      const Eigen::Ref<const Eigen::MatrixXd>& part) {
  const Place &a = place_[row], &b = place_[column];
  if (a.block > b.block || (a.block == b.block && a.at >= b.at))
    block(a.block, b.block).block(a.at, b.at, part.rows(), part.cols()) += part;
  else
    block(b.block, a.block).block(b.at, a.at, part.cols(), part.rows()) += part.transpose();
}

void BlockMatrix::add(std::size_t row, std::size_t column, double value) {
  add(row, column, Eigen::Matrix<double, 1, 1>(value));
}

Eigen::MatrixXd BlockMatrix::in_blocks(const Eigen::MatrixXd& x) const {
  Eigen::MatrixXd out(x.rows(), x.cols());
  for (std::size_t k = 0; k < place_.size(); ++k)
    out.row(begin_[place_[k].block] + place_[k].at) = x.row(static_cast<Eigen::Index>(k));
  return out;
}

bool BlockMatrix::factorise() {
  for (std::uint32_t c = 0; c < columns_.size(); ++c) {
    Column& column = columns_[c];
    Eigen::MatrixXd& diagonal = block(c, c);
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(diagonal);
    if (factor.info() != Eigen::Success) return false;
    for (auto at = std::next(column.begin()); at != column.end(); ++at) {
      factor.matrixU().solveInPlace<Eigen::OnTheRight>(at->second);
      for (auto left = std::next(column.begin()); left != at; ++left)
        block(at->first, left->first).noalias() -= at->second * left->second.transpose();
      block(at->first, at->first).selfadjointView<Eigen::Lower>().rankUpdate(at->second, -1.0);
    }
  }
  return true;
}

void BlockMatrix::forward(Eigen::MatrixXd& x, std::uint32_t first) const {
  for (std::uint32_t c = first; c < columns_.size(); ++c) {
    auto here = part_of(x, c);
    for (const auto& [r, block] : columns_[c])
      if (r == c)
        block.triangularView<Eigen::Lower>().solveInPlace(here);
      else
        part_of(x, r).noalias() -= block * here;
  }
}

Eigen::VectorXd BlockMatrix::solve(const Eigen::VectorXd& right) const {
  Eigen::MatrixXd x = in_blocks(right);
  forward(x, 0);
  for (std::size_t c = columns_.size(); c-- > 0;) {
    auto here = part_of(x, static_cast<std::uint32_t>(c));
    for (auto at = std::next(columns_[c].begin()); at != columns_[c].end(); ++at)
      here.noalias() -= at->second.transpose() * part_of(x, at->first);
    columns_[c].begin()->second.triangularView<Eigen::Lower>().transpose().solveInPlace(here);
  }
  Eigen::VectorXd out(right.size());
  for (std::size_t k = 0; k < place_.size(); ++k)
    out[static_cast<Eigen::Index>(k)] = x(begin_[place_[k].block] + place_[k].at, 0);
  return out;
}

Eigen::MatrixXd BlockMatrix::covariance(const Eigen::MatrixXd& functional) const {
  Eigen::MatrixXd x = in_blocks(functional);
  std::uint32_t first = 0;
  while (first < columns_.size() && part_of(x, first).isZero(0.0)) ++first;
  forward(x, first);
  return x.transpose() * x;
}

}  // namespace cloud
