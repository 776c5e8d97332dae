// Weights and their standard deviations where errors come in blocks.
#include "identify/clustered_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "base/interval90.h"
#include "base/random.h"

namespace clustered_fit_test {

using identify::ClusteredFit, identify::Equation;

struct Rows {
  Equation equation;
  std::vector<std::size_t> block;
};

/// 3 a + 0.5 b, b as even within a block as the error is: `blocks` of ten rows.
Rows rows(std::uint64_t seed, std::size_t blocks) {
  base::Random dice(seed);
  Rows out;
  out.equation.columns.resize(2);
  for (std::size_t g = 0; g < blocks; ++g) {
    const double b = 5.0 * dice.normal(), error = dice.normal();
    for (int i = 0; i < 10; ++i) {
      out.equation.columns[0].push_back(10.0 + 0.1 * dice.normal());
      out.equation.columns[1].push_back(b + dice.normal());
      out.equation.wanted.push_back(3.0 * out.equation.columns[0].back() +
                                    0.5 * out.equation.columns[1].back() + error +
                                    0.3 * dice.normal());
      out.block.push_back(7 * g);
    }
  }
  return out;
}

TEST(ClusteredFit, IntervalsHoldWhereErrorsComeInBlocks) {
  int inside = 0, inside_if_independent = 0;
  const int draws = 500;
  for (int k = 0; k < draws; ++k) {
    const Rows r = rows(1000u + static_cast<std::uint64_t>(k), 25);
    const ClusteredFit fit = identify::clustered_fit({r.equation}, r.block).or_throw();
    EXPECT_EQ(fit.blocks, 25u);
    std::vector<std::size_t> alone(r.block.size());
    for (std::size_t i = 0; i < alone.size(); ++i) alone[i] = i;
    const ClusteredFit rowwise = identify::clustered_fit({r.equation}, alone).or_throw();
    EXPECT_NEAR(rowwise.value[1], fit.value[1], 1e-9);
    const double off = std::abs(fit.value[1] - 0.5);
    inside += off < base::t90(23.0) * fit.sd(1) ? 1 : 0;
    inside_if_independent += off < 1.645 * rowwise.sd(1) ? 1 : 0;
  }
  EXPECT_GE(inside, 0.86 * draws);  // measured 91 %
  EXPECT_LE(inside, 0.96 * draws);
  EXPECT_LT(inside_if_independent, 0.7 * draws);  // why blocks are needed
}

TEST(ClusteredFit, EquationsShareTheirBlocks) {
  const Rows r = rows(5, 30);
  Equation doubled = r.equation;
  for (double& w : doubled.wanted) w *= 2.0;
  const ClusteredFit fit = identify::clustered_fit({r.equation, doubled}, r.block).or_throw();
  ASSERT_EQ(fit.value.size(), 4u);
  EXPECT_NEAR(fit.value[2], 2.0 * fit.value[0], 1e-9);
  // The second is twice the first, error and all: their difference to that is certain.
  EXPECT_NEAR(fit.sd_of({0.0, -2.0, 0.0, 1.0}), 0.0, 1e-9);
  EXPECT_NEAR(fit.sd_of({0.0, 1.0, 0.0, 1.0}), 3.0 * fit.sd(1), 1e-9);
}

TEST(ClusteredFit, RefusesWhatCannotBeTold) {
  Rows r = rows(5, 30);
  Rows few = rows(5, 3);
  EXPECT_THROW(identify::clustered_fit({few.equation}, few.block).or_throw(), base::Error);
  r.equation.columns[1] = r.equation.columns[0];
  EXPECT_THROW(identify::clustered_fit({r.equation}, r.block).or_throw(), base::Error);
  // Told apart by one block alone: not without it.
  for (std::size_t i = 0; i < 10; ++i) r.equation.columns[1][i] += 1.0 + static_cast<double>(i);
  EXPECT_THROW(identify::clustered_fit({r.equation}, r.block).or_throw(), base::Error);
}

}  // namespace clustered_fit_test
