#include "search.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "analysis.h"
#include "base/random.h"

namespace explain {
namespace search_test {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kRows = 1200;

Rows some_rows() {
  Rows rows;
  for (Index i = 0; i < kRows; ++i) {
    Row row;
    row.block = static_cast<int>(i / 10);
    row.lap = static_cast<int>(i / 300);
    row.fold = static_cast<int>(i / 150);
    row.u_m = static_cast<double>(i % 300);
    rows.row.push_back(row);
    rows.first_step.push_back(0);
  }
  rows.blocks = kRows / 10;
  rows.folds = 8;
  rows.laps = 4;
  return rows;
}

double normal(base::Random& dice) {
  return std::sqrt(-2 * std::log(1 - dice.uniform())) * std::cos(2 * M_PI * dice.uniform());
}

struct Problem {
  Rows rows = some_rows();
  MatrixXd x{kRows, 3};
  VectorXd noise{kRows};
  std::vector<Family> families;
  explicit Problem(unsigned seed) {
    base::Random dice(seed);
    for (Index i = 0; i < kRows; ++i) {
      noise[i] = normal(dice);
      for (Index j = 0; j < 3; ++j) x(i, j) = normal(dice);
    }
    for (std::size_t k = 0; k < 8; ++k) {
      Family f;
      f.column = VectorXd(kRows);
      for (Index i = 0; i < kRows; ++i)
        f.column[i] = std::sin(0.01 * static_cast<double>((k + 1) * static_cast<std::size_t>(i))) +
                      0.3 * x(i, 0);
      families.push_back(f);
    }
    Family road;
    road.column = VectorXd::Ones(kRows);
    road.cells = 30;
    road.lengths = {2, 4, 8};
    for (Index i = 0; i < kRows; ++i) road.cell.push_back(static_cast<int>(i % 300 / 10));
    families.push_back(road);
  }
  Fitted fitted(const VectorXd& r) const {
    return fit(x, r, VectorXd::Constant(3, 1e-6), VectorXd::Zero(3));
  }
};

TEST(Search, FalseAlarmsOfPureNoiseStayAtTheirRate) {
  // 200 independent noises; thresholds that 1.2 % of 300 replicates exceed: more than 8 alarms has
  // probability 0.1 %.
  int alarms = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    const Problem p(seed);
    const Fitted m = p.fitted(p.noise);
    const Scan s = scan(m, p.families, p.rows, 300, without_what_stands_out(m, p.families, p.rows));
    double most = 0;
    for (const explain::Test& t : s.best) most = std::max(most, std::abs(t.z));
    alarms += most > s.threshold ? 1 : 0;
  }
  EXPECT_LE(alarms, 8);
}

TEST(Search, FindsAndSizesWhatWasPlanted) {
  const Problem p(7);
  VectorXd r = p.noise;
  for (Index i = 0; i < kRows; ++i) {
    if (p.families[8].cell[static_cast<std::size_t>(i)] >= 12 &&
        p.families[8].cell[static_cast<std::size_t>(i)] < 16)
      r[i] += 0.8;
  }
  r += 2.0 * p.x.col(1);
  const Fitted m = p.fitted(r);
  const Scan s = scan(m, p.families, p.rows, 300, m.e);
  EXPECT_GT(std::abs(s.best[8].z), s.threshold);
  EXPECT_LE(std::abs(s.best[8].begin - 12), 1);
  EXPECT_LE(std::abs(s.best[8].end - 16), 1);
  EXPECT_NEAR(s.best[8].amount, 0.8, 0.2);
  EXPECT_NEAR(m.amount[1], 2.0, 0.1);
  // It predicts laps that were left out; a pattern that is not there does not.
  VectorXd here = VectorXd::Zero(kRows);
  for (Index i = 0; i < kRows; ++i)
    here[i] = p.families[8].cell[static_cast<std::size_t>(i)] / 4 == 3 ? 1 : 0;
  const auto sum = [](const std::vector<double>& v) {
    double total = 0;
    for (const double g : v) total += g;
    return total;
  };
  const VectorXd none = VectorXd::Zero(1), prior = VectorXd::Constant(3, 1e-6);
  EXPECT_GT(sum(cross_validate(m, here, prior, none, p.rows)), 40);
  EXPECT_LT(sum(cross_validate(m, p.families[2].column, prior, none, p.rows)), 6);
}

TEST(Search, AStretchOfAnyLengthIsNotDilutedByTheLengthsThatAreScanned) {
  const Problem p(7);
  for (const int begin : {3, 11, 18})
    for (const int length : {3, 6, 11}) {
      VectorXd r = p.noise;
      for (Index i = 0; i < kRows; ++i)
        if (const int cell = p.families[8].cell[static_cast<std::size_t>(i)];
            cell >= begin && cell < begin + length)
          r[i] += 1.0;
      const Fitted m = p.fitted(r);
      const explain::Test t = scan(m, p.families, p.rows, 0, m.e).best[8];
      EXPECT_EQ(t.begin, begin) << length;
      EXPECT_EQ(t.end, begin + length) << begin;
      EXPECT_NEAR(t.amount, 1.0, 3 / std::sqrt(40.0 * length));
      EXPECT_GE(t.gain, t.z * t.z);
    }
}

// Two columns that are nearly the same, like mass and brakes. One is held to a third of what it may
// be off by: the other takes its error, and its interval has to say so.
TEST(Search, AnAmountThatIsHeldTooNearMakesTheOthersLessSure) {
  constexpr double kHeld = 0.1, kMayBeOff = 0.3;
  Problem p(11);
  p.x.col(1) = p.x.col(0) + 0.05 * p.x.col(1);
  VectorXd precision = VectorXd::Constant(3, 1e-6), beyond = VectorXd::Zero(3);
  precision[0] = 1 / (kHeld * kHeld);
  beyond[0] = kMayBeOff * kMayBeOff - kHeld * kHeld;
  base::Random dice(5);
  constexpr int kDraws = 400;
  double square = 0, variance = 0, too_sure = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    VectorXd r = kMayBeOff * normal(dice) * p.x.col(0) + 2.0 * p.x.col(1);
    for (Index i = 0; i < kRows; ++i) r[i] += normal(dice);
    const Fitted m = fit(p.x, r, precision, VectorXd::Zero(3));
    square += (m.amount[1] - 2.0) * (m.amount[1] - 2.0) / kDraws;
    too_sure = m.normal.solve(MatrixXd::Identity(3, 3))(1, 1);
    variance = too_sure + held_too_near(m, precision, beyond)(1, 1);
  }
  fmt::print("error {:.4f}, said {:.4f}, by the prior alone {:.4f}\n", std::sqrt(square),
             std::sqrt(variance), std::sqrt(too_sure));
  EXPECT_NEAR(std::sqrt(square / variance), 1.0, 0.1);
  EXPECT_GT(square, 2 * too_sure);
}

TEST(Search, AFoldThatIsHeldOutIsNoFold) {
  Problem p(7);
  VectorXd column = p.families[2].column, r = p.noise + 0.3 * column;
  for (Index i = 300; i < 600; ++i) p.x.row(i).setZero(), r[i] = column[i] = 0;  // folds 2 and 3
  const std::vector<double> gains =
      cross_validate(p.fitted(r), column, VectorXd::Constant(3, 1e-6), VectorXd::Zero(1), p.rows);
  EXPECT_EQ(gains.size(), 6u);
  for (const double gain : gains) EXPECT_NE(gain, 0.0);
}

TEST(Search, ARoadLastsByTwiceWhatAnythingElseDoes) {
  const auto found = [](const char* kind, double value, double half) {
    Finding f;
    f.kind = kind;
    f.parameters = {{"amount", "1", value, value - half, value + half}};
    return f;
  };
  // A grade of 0.008 +- 0.006 that drag and throttle share; a banking of 0.025 +- 0.003.
  EXPECT_FALSE(lasts(found("road", 0.008, 0.006)));
  EXPECT_FALSE(lasts(found("road", -0.008, 0.006)));
  EXPECT_TRUE(lasts(found("parameter", 0.008, 0.006)));
  EXPECT_FALSE(lasts(found("parameter", 0.005, 0.006)));
  EXPECT_TRUE(lasts(found("road", -0.025, 0.003)));
}

TEST(Search, LeavesAloneWhatTheModelCanDoAlready) {
  Problem p(3);
  p.families[0].column = 5 * p.x.col(2);
  const Fitted m = p.fitted(p.noise + 3 * p.x.col(2));
  const Scan s = scan(m, p.families, p.rows, 100, m.e);
  EXPECT_EQ(s.best[0].gain, 0.0);
}

TEST(Search, FindsWhatTheModelCanNearlyDoIfAskedTo) {
  // A tenth of a new pattern beside what a column of the model does: 1 % of the square is left.
  Problem p(5);
  const VectorXd fresh = p.families[3].column;
  p.families[0].column = 5 * p.x.col(2) / p.x.col(2).norm() + 0.5 * fresh / fresh.norm();
  const VectorXd planted = 30.0 * p.families[0].column;
  const Fitted m = p.fitted(p.noise + planted);
  EXPECT_EQ(scan(m, p.families, p.rows, 0, m.e).best[0].gain, 0.0);
  p.families[0].least_left = 0.0;
  const explain::Test t = scan(m, p.families, p.rows, 0, m.e).best[0];
  EXPECT_NEAR(t.amount, 30.0, 3 * 2.0);  // three standard deviations: 1 over the half that is left
  EXPECT_GT(std::abs(t.z), 9.0);
  // Flipped with it, the effect would be its own null.
  const VectorXd left = without_what_stands_out(m, p.families, p.rows);
  EXPECT_LT(std::abs(left.dot(fresh)) / fresh.norm(), 3.0);
}

// One of three effects at once must not hide behind the noise that the others would make.
TEST(Search, WhatWasFoundIsNoNoise) {
  double alone = 0, beside = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Problem p(seed);
    const auto threshold = [&](const VectorXd& r) {
      const Fitted m = p.fitted(r);
      return scan(m, p.families, p.rows, 300, without_what_stands_out(m, p.families, p.rows))
          .threshold;
    };
    alone += threshold(p.noise) / 20;
    beside += threshold(p.noise + 2.0 * p.families[0].column + 1.0 * p.families[4].column +
                        0.5 * p.families[7].column) /
              20;
  }
  EXPECT_NEAR(beside, alone, 0.1 * alone);
}

}  // namespace search_test
}  // namespace explain
