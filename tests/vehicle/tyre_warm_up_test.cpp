#include "vehicle/laws/tyre_warm_up.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tyre_warm_up_test {

using namespace vehicle;  // NOLINT: a test of this library

// 6.4 m/s2 to either side: work 1, so the stated time is the time constant; straight on a fifth of
// it, and no more than three times it.
TEST(TyreWarmUp, FollowsTheLateralAcceleration) {
  EXPECT_NEAR(laws::warm_up_work<double>(6.4), 1, 1e-12);
  EXPECT_NEAR(laws::warm_up_work<double>(-6.4), 1, 1e-12);
  EXPECT_NEAR(laws::warm_up_work<double>(0), 0.2, 1e-12);
  EXPECT_EQ(laws::warm_up_work<double>(100), 3);
  EXPECT_NEAR(laws::warmth_after<double>(0, 50, 6.4, 50), 1 - std::exp(-1.0), 1e-12);
  EXPECT_NEAR(laws::warmth_after<double>(0, 50, 0, 250), 1 - std::exp(-1.0), 1e-12);
}

TEST(TyreWarmUp, StepsAsItsRateSays) {
  double warmth = 0.2;
  for (int i = 0; i < 10000; ++i) warmth += 1e-3 * laws::warm_up_rate<double>(warmth, 50, 12);
  EXPECT_NEAR(warmth, laws::warmth_after<double>(0.2, 50, 12, 10), 1e-5);
}

// Cold: the whole loss of grip and half of it of stiffness; warm: none.
TEST(TyreWarmUp, GivesBackWhatWasMissing) {
  EXPECT_NEAR(laws::warm_up_missing<double>(0.1, 0), 0.1, 1e-12);
  EXPECT_NEAR(laws::warm_up_missing<double>(0.1, 0.4), 0.06, 1e-12);
  EXPECT_EQ(laws::warm_up_missing<double>(0.1, 1.2), 0);
  EXPECT_NEAR(laws::warm_up_stiffness<double>(0.1), 0.95, 1e-12);
}

}  // namespace tyre_warm_up_test
