#include "vehicle/laws/engine.h"

#include <gtest/gtest.h>

namespace engine_test {

using namespace vehicle;  // NOLINT: a test of this library
using P = Parameter;

TEST(Engine, ReadsItsMapTimesItsFactor) {
  const Map2 map{{0, 100}, {0, 1}, {-10, 90, -30, 210}};
  EXPECT_DOUBLE_EQ(laws::map_torque<double>(1, map, 50, 0.5), 65);
  EXPECT_DOUBLE_EQ(laws::map_torque<double>(0.5, map, 50, 0.5), 32.5);
}

// A limiter at 800 rad/s cuts from there, half of it at 808, all at 816; drag stays.
TEST(Engine, IsCutByItsLimiter) {
  EXPECT_EQ(laws::fuelled_share<double>(800, 799), 1);
  EXPECT_NEAR(laws::fuelled_share<double>(800, 808), 0.5, 1e-12);
  EXPECT_EQ(laws::fuelled_share<double>(800, 820), 0);
  EXPECT_EQ(laws::limited_torque<double>(300, 0.5), 150);
  EXPECT_EQ(laws::limited_torque<double>(-40, 0.5), -40);
}

TEST(Engine, IdlesWithoutEverBraking) {
  Parameters<double> p = default_parameters();
  p[P::engine_idle_radps] = 100;
  p[P::engine_idle_gain_nms] = 2;
  EXPECT_EQ(laws::idle_torque<double>(p, 90), 20);
  EXPECT_EQ(laws::idle_torque<double>(p, 130), 0);
}

// With the whole share, 1 % of the difference is left after the shift: integrated here.
TEST(Engine, MatchesItsSpeedDuringAShift) {
  Parameters<double> p = default_parameters();
  p[P::gearbox_rev_match] = 1;
  double speed = 600;
  const double step = p[P::gearbox_shift_s] / 20000;
  for (int i = 0; i < 20000; ++i)
    speed += step * laws::rev_match_torque<double>(p, 999, speed, 500) / p[P::engine_inertia_kgm2];
  EXPECT_NEAR(speed, 501, 0.01);
  p[P::gearbox_rev_match] = 0;
  EXPECT_EQ(laws::rev_match_torque<double>(p, 50, 600, 500), 50);
}

}  // namespace engine_test
