#include "vehicle/laws/boost.h"

#include <gtest/gtest.h>

#include <cmath>

namespace boost_test {

using namespace vehicle;  // NOLINT: a test of this library
const laws::BoostParameters<double> kBoost{0.35, 0.12, 600, 0.15};

// By the parameter list's words: at full throttle and the reference speed turbo.rise_s is the time
// constant, so 63.2 % after it; at half the speed it takes twice as long; at closed throttle
// nothing but turbo.fall_s counts.
TEST(Boost, HasTheTimeConstantsThatItsParametersSay) {
  const auto after = [](double boost, double engine, double throttle, double time) {
    return laws::boost_after<double>(kBoost, boost, engine, throttle, time);
  };
  EXPECT_NEAR(after(0, 600, 1, 0.35), 1 - std::exp(-1.0), 1e-12);
  EXPECT_NEAR(after(0, 300, 1, 0.70), 1 - std::exp(-1.0), 1e-12);
  EXPECT_NEAR(after(1, 600, 0, 0.12), std::exp(-1.0), 1e-12);
  EXPECT_NEAR(after(1, 100, 0, 0.12), std::exp(-1.0), 1e-12);
  // Half throttle: flow 0.15 + 0.85 / 2 = 0.575 of the full one.
  EXPECT_NEAR(after(0, 600, 0.5, 0.35 / 0.575), 0.5 * (1 - std::exp(-1.0)), 1e-12);
}

// Small steps of the rate end where the exact step ends.
TEST(Boost, StepsAsItsRateSays) {
  double boost = 0.1;
  for (int i = 0; i < 20000; ++i) boost += 1e-5 * laws::boost_rate<double>(kBoost, boost, 450, 0.8);
  EXPECT_NEAR(boost, laws::boost_after<double>(kBoost, 0.1, 450, 0.8, 0.2), 1e-5);
}

TEST(Boost, ExhaustOfAStandingOrRacingEngineStaysInBounds) {
  EXPECT_EQ(laws::boost_lag<double>(kBoost, 0.5, 0, 1).flow, 0.02);
  EXPECT_EQ(laws::boost_lag<double>(kBoost, 0.5, 1e9, 1).flow, 10.0);
}

TEST(Boost, HoldsBackDrivingTorqueAlone) {
  EXPECT_DOUBLE_EQ(laws::boosted_torque<double>(200, 0.5, 0.4), 160);
  EXPECT_DOUBLE_EQ(laws::boosted_torque<double>(200, 0.5, -0.4), 200);  // more boost than asked for
  EXPECT_DOUBLE_EQ(laws::boosted_torque<double>(-30, 0.5, 0.4), -30);
}

}  // namespace boost_test
