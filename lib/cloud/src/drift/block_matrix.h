// A symmetric positive definite matrix of dense blocks, most of which are zero, and its factor.
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <map>
#include <vector>

namespace cloud {

/// Unknowns that belong together stand in one block, so that products of blocks do the work: where
/// ten passes see each other nearly every entry of a block is there.
class BlockMatrix {
 public:
  /// `block_of`: of each unknown. Blocks are eliminated in the order of their numbers.
  explicit BlockMatrix(const std::vector<std::uint32_t>& block_of = {});

  Eigen::Index unknowns() const { return static_cast<Eigen::Index>(place_.size()); }
  void set_zero();
  void scale(double times);
  /// Adds to the entries of the unknowns from `row` and from `column` on, and to their mirrors;
  /// those of each must be neighbours in one block. row == column: the lower triangle counts.
  void add(std::size_t row, std::size_t column, const Eigen::Ref<const Eigen::MatrixXd>& part);
  void add(std::size_t row, std::size_t column, double value);

  /// Makes it its own factor, after which only the following may be asked; false: it is not
  /// positive definite.
  bool factorise();
  Eigen::VectorXd solve(const Eigen::VectorXd& right) const;
  /// Transposed functional times inverse times functional.
  Eigen::MatrixXd covariance(const Eigen::MatrixXd& functional) const;

 private:
  struct Place {
    std::uint32_t block = 0;
    Eigen::Index at = 0;  ///< in the block
  };
  using Column = std::map<std::uint32_t, Eigen::MatrixXd>;  ///< from the diagonal on, by row
  Eigen::MatrixXd& block(std::uint32_t row, std::uint32_t column);
  auto part_of(auto& x, std::uint32_t block) const {
    return x.middleRows(begin_[block], begin_[block + 1] - begin_[block]);
  }
  Eigen::MatrixXd in_blocks(const Eigen::MatrixXd& x) const;
  /// The factor's inverse times x, from this block on: before it x is zero.
  void forward(Eigen::MatrixXd& x, std::uint32_t first) const;

  std::vector<Place> place_;         ///< of each unknown
  std::vector<Eigen::Index> begin_;  ///< of each block, and the end
  std::vector<Column> columns_;
};

}  // namespace cloud
