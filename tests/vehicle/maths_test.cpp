#include "vehicle/maths.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace maths_test {

namespace maths = vehicle::maths;

/// The largest error against the library's function in long double, in units of the last place.
template <class F, class Exact>
double most_ulps(double from, double to, const F& f, const Exact& exact) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> places(from, to);
  double most = 0.0;
  for (int k = 0; k < 20000; ++k) {
    double x = places(random);
    if (k % 4 == 0) x *= std::pow(10.0, -(k % 32));
    if (x < from) continue;
    const long double wanted = exact(static_cast<long double>(x));
    const double near = static_cast<double>(wanted);
    const double ulp = std::nextafter(std::abs(near), 1e308) - std::abs(near);
    most = std::max(most, static_cast<double>(std::abs(f(x) - wanted)) / ulp);
  }
  return most;
}

#define KERBSTONE_ULPS(name, from, to, bound)                      \
  EXPECT_LT(most_ulps(                                             \
                from, to, [](double x) { return maths::name(x); }, \
                [](long double x) { return std::name(x); }),       \
            bound)

TEST(Maths, IsRightToAboutTheLastPlace) {
  KERBSTONE_ULPS(sin, -3.0, 3.0, 1.7);
  KERBSTONE_ULPS(cos, -1.5, 1.5, 1.7);
  KERBSTONE_ULPS(atan, -50.0, 50.0, 1.6);
  KERBSTONE_ULPS(atan, -1.6, 1.6, 1.6);
  KERBSTONE_ULPS(exp, -700.0, 700.0, 1.5);
  KERBSTONE_ULPS(exp, -1.0, 1.0, 1.5);
  KERBSTONE_ULPS(log, 1e-6, 1e6, 2.0);
  KERBSTONE_ULPS(tanh, -3.0, 3.0, 4.0);
  KERBSTONE_ULPS(asin, -0.99, 0.99, 3.0);
}

// A wheel beside another, an angle beside another: each as if it were alone.
TEST(Maths, OfTwoNumbersIsThatOfEach) {
  using vehicle::Pack;
  const auto same = [](double a, double b) {
    return a == b ? std::signbit(a) == std::signbit(b) : std::isnan(a) && std::isnan(b);
  };
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> exponent(-12.0, 6.0);
  std::vector<double> values{
      0.0, -0.0, 0.625, 15.9, 7.9, -800.0, 1e-310, NAN, std::numeric_limits<double>::infinity()};
  for (int k = 0; k < 4000; ++k)
    values.push_back((k % 2 == 0 ? 1.0 : -1.0) * std::pow(10.0, exponent(random)));
  for (std::size_t k = 0; k + 1 < values.size(); ++k) {
    const std::array<double, 2> x{values[k], values[values.size() - 1 - k]};
    const Pack<2> both = vehicle::pair(x[0], x[1]);
    const auto waves = maths::waves_of(x[0], x[1]);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_TRUE(same(maths::sin(both)[i], maths::sin(x[i]))) << x[i];
      EXPECT_TRUE(same(maths::cos(both)[i], maths::cos(x[i]))) << x[i];
      EXPECT_TRUE(same(maths::atan(both)[i], maths::atan(x[i]))) << x[i];
      EXPECT_TRUE(same(maths::exp(both)[i], maths::exp(x[i]))) << x[i];
      EXPECT_TRUE(same(maths::tanh(both)[i], maths::tanh(x[i]))) << x[i];
      EXPECT_TRUE(same(maths::log(both)[i], maths::log(x[i]))) << x[i];
      EXPECT_TRUE(same(sqrt(both)[i], std::sqrt(x[i]))) << x[i];
      EXPECT_TRUE(same(waves[i].sine, maths::sin(x[i]))) << x[i];
      EXPECT_TRUE(same(waves[i].cosine, maths::cos(x[i]))) << x[i];
    }
  }
}

TEST(Maths, TurnsManyTimes) {
  for (double x = -9e4; x < 9e4; x += 7.77) {
    EXPECT_NEAR(maths::sin(x), std::sin(x), 9e-16);
    EXPECT_NEAR(maths::cos(x), std::cos(x), 9e-16);
  }
}

TEST(Maths, PowersAndAnglesAreRight) {
  for (const double x : {1e-9, 0.3, 1.0, 7.0, 4e5, 3e7})
    for (const double y : {0.8, 1.0 / 3.0, -0.667, 0.2857})
      EXPECT_NEAR(maths::pow(x, y) / std::pow(x, y), 1.0, 1e-14) << x << " " << y;
  for (double angle = -3.1; angle < 3.14; angle += 0.01)
    EXPECT_NEAR(maths::atan2(7.0 * std::sin(angle), 7.0 * std::cos(angle)), angle, 1e-15);
  for (const double x : {-0.9, 0.0, 0.5, 0.99}) EXPECT_NEAR(maths::acos(x), std::acos(x), 1e-15);
}

TEST(Maths, AnswersAtTheEnds) {
  const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
  EXPECT_EQ(maths::exp(-inf), 0.0);
  EXPECT_EQ(maths::exp(inf), inf);
  EXPECT_EQ(maths::exp(-740.0), std::exp(-740.0));
  EXPECT_EQ(maths::exp(0.0), 1.0);
  EXPECT_EQ(maths::tanh(inf), 1.0);
  EXPECT_EQ(maths::tanh(-30.0), -1.0);
  EXPECT_EQ(maths::atan(inf), std::atan(inf));
  EXPECT_EQ(maths::atan(-inf), std::atan(-inf));
  EXPECT_EQ(maths::pow(0.0, 0.5), 0.0);
  EXPECT_EQ(maths::log(0.0), -inf);
  EXPECT_EQ(maths::sin(1e300), std::sin(1e300));
  EXPECT_EQ(maths::cos(0.0), 1.0);
  double (*const functions[])(double) = {maths::sin, maths::cos, maths::atan,
                                         maths::exp, maths::log, maths::tanh};
  for (const auto f : functions) EXPECT_TRUE(std::isnan(f(nan)));
}

}  // namespace maths_test
