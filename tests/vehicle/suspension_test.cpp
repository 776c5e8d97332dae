#include "vehicle/laws/suspension.h"

#include <gtest/gtest.h>

#include <cmath>

namespace suspension_test {

using namespace vehicle;  // NOLINT: a test of this library
using P = Parameter;

// The roll centre is where the line from the contact through the wheel's instant centre meets the
// middle of the car: over half a track of 0.8 m a wheel that moves 0.025 outwards per metre of
// bump has its contact's path perpendicular to a line that is 0.02 m high there.
TEST(Suspension, PathPointsAtTheRollCentre) {
  const Parameters<double> p = default_parameters();
  const auto left = laws::wheel_motion<double>(p, {}, 1, 0, 1, 0.01);
  const auto right = laws::wheel_motion<double>(p, {}, 1, 0, -1, 0.01);
  const double half = 0.5 * p[P::front_track_m];
  EXPECT_NEAR(left.slide.y * half, p[P::front_roll_centre_m], 1e-12);
  EXPECT_EQ(left.slide.y, -right.slide.y);
  // Anti-dive: the front wheel moves ahead going up, the rear one back (anti-lift).
  EXPECT_NEAR(left.slide.x, p[P::front_anti_slope], 1e-12);
  EXPECT_NEAR(laws::wheel_motion<double>(p, {}, 1, 1, 1, 0.01).slide.x, -p[P::rear_anti_slope],
              1e-12);
  EXPECT_NEAR(left.camber_rad, p[P::front_camber_rad] + 0.01 * p[P::front_camber_gain_radpm],
              1e-12);
}

TEST(Suspension, WithoutKinematicsWheelsMoveStraightUp) {
  const Parameters<double> p = default_parameters();
  WheelPath path;
  path.range_m = 0.1;
  path.ahead_m[0] = 0.2;
  path.camber_rad[0] = -1;
  const auto off = laws::wheel_motion<double>(p, path, 0, 0, 1, 0.03);
  EXPECT_EQ(off.slide.x, 0);
  EXPECT_EQ(off.slide.y, 0);
  EXPECT_EQ(off.slide.z, 1);
  EXPECT_EQ(off.camber_rad, p[P::front_camber_rad]);
  // With a path: its place and slope, mirrored on the right, and by its amount.
  const auto on = laws::wheel_motion<double>(p, path, 0.5, 0, -1, 0.03);
  EXPECT_TRUE(on.curved);
  EXPECT_NEAR(on.away_m.x, 0.003, 1e-12);
  EXPECT_NEAR(on.slide.x, 0.1, 1e-12);
  EXPECT_NEAR(on.camber_rad, p[P::front_camber_rad] - 0.015, 1e-12);
  EXPECT_NEAR(on.turn.x, -0.5, 1e-12);
}

// 0.02 rad, full Ackermann, 1.6 m of track and 3 m of wheelbase. Exactly: a turning centre 3 / tan
// 0.02 = 149.98 m to the left of the middle; the left wheel turns by atan(3 / 149.18) = 0.020107.
TEST(Suspension, AckermannsWheelsPointToOneCentre) {
  Parameters<double> p = default_parameters();
  p[P::steering_ackermann] = 1;
  const double left = std::atan(3 / (3 / std::tan(0.02) - 0.8));
  EXPECT_NEAR(laws::ackermann_angle<double>(p, 1, 0.02), left, 2e-6);
  const double right = std::atan(3 / (3 / std::tan(0.02) + 0.8));
  EXPECT_NEAR(laws::ackermann_angle<double>(p, -1, 0.02), right, 2e-6);
}

// Front of the default car: 150 N/mm, bar 90 N/mm, stop 3e7 N/m2 from 25 mm of bump, droop 40 mm.
TEST(Suspension, SpringsBarsAndStopsAddUp) {
  const Parameters<double> p = default_parameters();
  const auto force = [&](double bar, double stops, double travel, double other) {
    return laws::spring_force<double>(p, {bar, stops}, 0, 1, 1500, travel, other);
  };
  EXPECT_NEAR(force(0, 0, 0.01, -0.01), -1500 - 1500, 1e-9);
  EXPECT_NEAR(force(1, 0, 0.01, -0.01), -3000 - 1800, 1e-9);
  EXPECT_NEAR(force(0, 1, 0.027, 0), -1500 - 4050 - 120, 1e-9);  // 3e7 (2 mm)^2
  EXPECT_NEAR(force(0, 0.5, 0.027, 0), -1500 - 4050 - 60, 1e-9);
  EXPECT_NEAR(force(0, 1, -0.043, 0), -1500 + 6450 + 270, 1e-9);  // 3e7 (3 mm)^2
}

// 150 N/mm, left 20 more and right 20 less; perches 400 N; 1 cm of travel.
TEST(Suspension, LeftAndRightAreSetApart) {
  Parameters<double> p = default_parameters();
  p[P::front_spring_split_npm] = 20000;
  p[P::front_perch_split_n] = 400;
  p[P::front_camber_split_rad] = 0.06;
  p[P::rear_toe_split_rad] = -0.003;
  const auto force = [&](double side) {
    return laws::spring_force<double>(p, {0, 0}, 0, side, 1500, 0.01, 0);
  };
  EXPECT_NEAR(force(1), -1500 - 400 - 1700, 1e-9);
  EXPECT_NEAR(force(-1), -1500 + 400 - 1300, 1e-9);
  EXPECT_NEAR(laws::wheel_motion<double>(p, {}, 0, 0, 1, 0).camber_rad, 0.015, 1e-12);
  EXPECT_NEAR(laws::wheel_motion<double>(p, {}, 0, 0, -1, 0).camber_rad, -0.105, 1e-12);
  EXPECT_NEAR(laws::wheel_motion<double>(p, {}, 0, 1, 1, 0).toe_rad, -0.001, 1e-12);
  EXPECT_NEAR(laws::wheel_motion<double>(p, {}, 0, 1, -1, 0).toe_rad, 0.005, 1e-12);
}

// Slow travel: the stated damping; far beyond the knee: the fast share of it; odd but for the
// different damping of bump and rebound.
TEST(Suspension, DampersGiveWayBeyondTheirKnee) {
  const Parameters<double> p = default_parameters();
  const auto force = [&](double rate) { return laws::damper_force<double>(p, 0, rate); };
  EXPECT_NEAR(force(1e-4) / 1e-4, 5500, 1);
  EXPECT_NEAR(force(-1e-4) / -1e-4, 7500, 1);
  EXPECT_NEAR(force(2.0) - force(1.0), 0.35 * 5500, 1e-6);
  EXPECT_EQ(force(0.0), 0.0);
}

}  // namespace suspension_test
