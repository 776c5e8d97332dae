#include "vehicle/racing_line.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "test_car.h"
#include "test_roads.h"
#include "vehicle/error.h"

namespace {

using namespace vehicle;  // NOLINT: a test of this library

TEST(RacingLine, StaysOnTheRoadAndBendsLessThanTheEdgeItCutsTo) {
  const crg::Surface surface(stadium());
  const RacingLine line = plan_line(surface);
  ASSERT_TRUE(line.closed);
  double differences = 0.0, middle = 0.0;
  for (std::size_t i = 0; i < line.v_m.size(); ++i) {
    EXPECT_LE(std::abs(line.v_m[i]), 7.0 - 1.6 + 1e-9);
    EXPECT_LT(std::abs(line.curvature_1pm[i]), 1.01 / (40.0 - 5.4));
    const double ds =
        i + 1 < line.s_m.size() ? line.s_m[i + 1] - line.s_m[i] : line.length_m - line.s_m[i];
    differences += std::pow(line.curvature_1pm[i] * ds * ds, 2);
  }
  // The middle of the road: 1/40 over two half circles.
  const double station = line.u_step_m;
  middle = 2 * std::numbers::pi * 40.0 / station * std::pow(station * station / 40.0, 2);
  EXPECT_LT(differences, 0.8 * middle);
  EXPECT_NEAR(line.heading_rad.back() - line.heading_rad.front(), 2 * std::numbers::pi, 0.3);
}

TEST(RacingLine, RefusesARoadThatIsTooNarrow) {
  const crg::Surface surface(stadium());
  EXPECT_THROW(plan_line(surface, {.margin_m = 8.0}), Error);
}

TEST(RacingLine, IsAsFastAsTheTyresAllowInASteadyTurn) {
  const crg::Surface surface(stadium());
  RacingLine line = plan_line(surface);
  const CarFiles files = test_car_files();
  Amplitudes<double> terms = default_amplitudes();
  terms[Term::aero_downforce] = terms[Term::tyre_thermal] = 0.0;
  const Car<double> car = make_car(files, default_parameters(), terms);
  SpeedOptions options;
  options.grip_usage = 0.5;
  plan_speed(line, car, options);
  double most = 0.0;
  for (std::size_t i = 0; i < line.v_m.size(); ++i)
    most = std::max(most, line.speed_mps[i] * line.speed_mps[i] * std::abs(line.curvature_1pm[i]));
  // Half of a friction near the file's 1.7, times gravity.
  EXPECT_GT(most, 0.5 * 1.5 * 9.8);
  EXPECT_LT(most, 0.5 * 1.9 * 9.8);
  options.grip_usage = 0.25;
  RacingLine slow = line;
  plan_speed(slow, car, options);
  for (std::size_t i = 0; i < line.v_m.size(); ++i) EXPECT_LE(slow.speed_mps[i], line.speed_mps[i]);
}

}  // namespace
