#include "vehicle/laws/clip.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

namespace clip_test {

using namespace vehicle;  // NOLINT: a test of this library

TEST(Clip, HoldsValueAndDropsTheSlopeOutside) {
  using Jet = ceres::Jet<double, 1>;
  EXPECT_EQ(laws::clip(0.3, 0.0, 1.0), 0.3);
  EXPECT_EQ(laws::clip(Jet(1.5, 0), 0.0, 1.0).a, 1.0);
  EXPECT_EQ(laws::clip(Jet(1.5, 0), 0.0, 1.0).v[0], 0.0);
  EXPECT_EQ(laws::clip(Jet(0.5, 0), 0.0, 1.0).v[0], 1.0);
}

// Half way up half way along, level at both ends.
TEST(Clip, StepsWithoutAKink) {
  using Jet = ceres::Jet<double, 1>;
  EXPECT_EQ(laws::smooth_step(-1.0), 0.0);
  EXPECT_EQ(laws::smooth_step(0.5), 0.5);
  EXPECT_EQ(laws::smooth_step(2.0), 1.0);
  EXPECT_NEAR(laws::smooth_step(Jet(1e-9, 0)).v[0], 0.0, 1e-8);
  EXPECT_NEAR(laws::smooth_step(Jet(1.0 - 1e-9, 0)).v[0], 0.0, 1e-8);
}

}  // namespace clip_test
