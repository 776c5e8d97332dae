#include "vehicle/laws/brake_pads.h"

#include <gtest/gtest.h>

#include <cmath>

namespace brake_pads_test {

using namespace vehicle;  // NOLINT: a test of this library

// Two faces, 40 cm2 at 3 MPa each press with 12 kN; 0.42 of that at 0.125 m, twice: 1260 N m.
TEST(BrakePads, RubOnTwoFaces) {
  EXPECT_NEAR(laws::brake_torque<double>(0.42, 3e6, 0.0040, 0.125), 1260, 1e-9);
}

TEST(BrakePads, TakeTheMapsFrictionByTheirAmount) {
  const Map2 map{{0.0, 1e7}, {300, 600}, {0.30, 0.50, 0.30, 0.50}};
  EXPECT_DOUBLE_EQ(laws::pad_friction<double>(0.42, 1, map, 3e6, 450), 0.40);
  EXPECT_DOUBLE_EQ(laws::pad_friction<double>(0.42, 0.5, map, 3e6, 450), 0.41);
  EXPECT_DOUBLE_EQ(laws::pad_friction<double>(0.42, 1, {}, 3e6, 450), 0.42);
}

// 0.2 per MJ: after 0.75 MJ 15 % is gone; half of it where half of the term acts. Never more than
// 95 % gone, never more than twice as much bite.
TEST(BrakePads, FadeByTheHeatThatTheyHold) {
  EXPECT_NEAR(laws::pad_bite<double>(1, 0.2, 0.75e6), 0.85, 1e-12);
  EXPECT_NEAR(laws::pad_bite<double>(0.5, 0.2, 0.75e6), 0.925, 1e-12);
  EXPECT_NEAR(laws::pad_bite<double>(1, -0.2, 0.75e6), 1.15, 1e-12);
  EXPECT_NEAR(laws::pad_bite<double>(1, 0.2, 1e9), 0.05, 1e-12);
  EXPECT_NEAR(laws::pad_bite<double>(1, -0.2, 1e9), 2.0, 1e-12);
}

// Under constant power the heat tends to power times time constant, with that time constant.
TEST(BrakePads, HoldHeatForTheirTime) {
  double heat = 0;
  for (int i = 0; i < 100000; ++i) heat += 1e-4 * laws::pad_heat_rate<double>(50e3, heat, 10);
  EXPECT_NEAR(heat, 500e3 * (1 - std::exp(-1.0)), 10);
  EXPECT_EQ(laws::pad_heat_rate<double>(0, 1e6, 10), -1e5);
}

}  // namespace brake_pads_test
