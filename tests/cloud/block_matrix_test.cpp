// Sums of squares over a few unknowns each, in blocks of different sizes, against a dense matrix.
#include "block_matrix.h"

#include <gtest/gtest.h>

#include "base/random.h"

namespace cloud {
namespace block_matrix_test {

/// Blocks in another order than the unknowns; the last one is seen by all others.
const std::vector<std::uint32_t> kBlockOf = {2, 2, 0, 0, 0, 1, 1, 3, 3, 3, 3, 0, 4, 4, 5};

struct Both {
  BlockMatrix blocks{kBlockOf};
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(15, 15);

  void add(std::size_t row, std::size_t column, const Eigen::MatrixXd& part) {
    blocks.add(row, column, part);
    const auto a = static_cast<Eigen::Index>(row), b = static_cast<Eigen::Index>(column);
    dense.block(a, b, part.rows(), part.cols()) += part;
    if (a != b) dense.block(b, a, part.cols(), part.rows()) += part.transpose();
  }
};

Both example() {
  Both both;
  base::Random random(3);
  for (std::size_t k = 0; k < kBlockOf.size(); ++k)
    both.add(k, k, Eigen::MatrixXd::Constant(1, 1, 30.0 + 10.0 * random.uniform()));
  const auto couple = [&](std::size_t a, std::size_t na, std::size_t b, std::size_t nb) {
    Eigen::MatrixXd part(na, nb);
    for (double& value : part.reshaped()) value = random.normal();
    both.add(a, b, part);
  };
  couple(0, 2, 2, 3), couple(5, 2, 0, 2), couple(7, 4, 2, 3), couple(12, 2, 7, 4);
  couple(2, 2, 4, 1), couple(11, 1, 2, 3);
  for (std::size_t k = 0; k < 14; ++k) couple(14, 1, k, 1);
  return both;
}

TEST(BlockMatrix, AnswersAsADenseOne) {
  Both both = example();
  ASSERT_TRUE(both.blocks.factorise());
  const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(15, -1.0, 2.0);
  EXPECT_LT((both.dense * both.blocks.solve(right) - right).norm(), 1e-12);
  const Eigen::MatrixXd inverse = both.dense.inverse();
  for (Eigen::Index k = 0; k < 14; ++k) {  // from its block on, a functional is not zero
    Eigen::MatrixXd two = Eigen::MatrixXd::Zero(15, 2);
    two(k, 0) = 1.0, two(14, 1) = 2.0;
    EXPECT_LT((both.blocks.covariance(two) - two.transpose() * inverse * two).norm(), 1e-14);
  }
}

TEST(BlockMatrix, WithoutAPositiveDefiniteMatrixHasNoFactor) {
  Both both = example();
  both.blocks.add(3, 3, -100.0);
  EXPECT_FALSE(both.blocks.factorise());
}

TEST(BlockMatrix, IsScaledAndBegunAgain) {
  Both both = example();
  both.blocks.scale(4.0);
  ASSERT_TRUE(both.blocks.factorise());
  const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(15, -1.0, 2.0);
  EXPECT_LT((4.0 * both.dense * both.blocks.solve(right) - right).norm(), 1e-12);
  both.blocks.set_zero();
  for (std::size_t k = 0; k < kBlockOf.size(); ++k) both.blocks.add(k, k, 4.0);
  ASSERT_TRUE(both.blocks.factorise());
  EXPECT_LT((4.0 * both.blocks.solve(right) - right).norm(), 1e-14);
}

}  // namespace block_matrix_test
}  // namespace cloud
