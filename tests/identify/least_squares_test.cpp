// Unknowns of formulas from rows whose answers are known.
#include "identify/least_squares.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"

namespace least_squares_test {

using identify::Unknown;

TEST(LeastSquares, FindsWhatMadeTheRows) {
  std::vector<double> x, y;
  for (int i = 0; i <= 40; ++i) {
    x.push_back(0.1 * i);
    y.push_back(2.5 * std::exp(-0.7 * x.back()) + 0.3);
  }
  std::vector<Unknown> unknowns{
      {"a", 1.0, 0.0, 10.0, 1.0}, {"rate", 0.2, 0.0, 5.0, 1.0}, {"rest", 0.0, -1.0, 1.0, 1.0}};
  const auto found = identify::least_squares(
      unknowns, [&](const std::vector<double>& v, std::vector<double>& left) {
        left.resize(x.size());
        for (std::size_t i = 0; i < x.size(); ++i)
          left[i] = v[0] * std::exp(-v[1] * x[i]) + v[2] - y[i];
      });
  EXPECT_TRUE(found.converged);
  EXPECT_NEAR(unknowns[0].value, 2.5, 1e-5);
  EXPECT_NEAR(unknowns[1].value, 0.7, 1e-5);
  EXPECT_NEAR(unknowns[2].value, 0.3, 1e-5);
}

TEST(LeastSquares, StaysWithinBounds) {
  std::vector<Unknown> unknowns{{"x", 0.5, 0.0, 1.0, 1.0}};
  identify::least_squares(unknowns, [](const std::vector<double>& v, std::vector<double>& left) {
    left = {v[0] - 3.0};
  });
  EXPECT_DOUBLE_EQ(unknowns[0].value, 1.0);
}

TEST(LeastSquares, ABeginThatIsNotFiniteIsRefused) {
  std::vector<Unknown> unknowns{{"x", 0.0, -1.0, 1.0, 1.0}};
  EXPECT_THROW(
      identify::least_squares(unknowns, [](const std::vector<double>& v,
                                           std::vector<double>& left) { left = {1.0 / v[0]}; }),
      base::Error);
}

TEST(LeastSquares, WeightsOfColumns) {
  // 2 a - 3 b, columns of sizes far apart, and one that is never there.
  identify::Equation e;
  for (const auto& [a, b] : {std::pair{1.0, 1e6}, {2.0, -2e6}, {3.0, 1e6}, {4.0, 5e6}})
    e.add({a, b, 0.0}, 2.0 * a - 3.0 * b);
  const std::vector<double> found = identify::linear_fit(e);
  EXPECT_NEAR(found[0], 2.0, 1e-6);
  EXPECT_NEAR(found[1], -3.0, 1e-9);
  EXPECT_EQ(found[2], 0.0);
}

}  // namespace least_squares_test
