#include "vehicle/racing_line.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "test_car.h"
#include "test_roads.h"
#include "vehicle/error.h"

namespace racing_line_test {

using namespace vehicle;  // NOLINT: a test of this library

/// Integral of the squared curvature of a closed path, 1/m: turns between chords over lengths.
double bending(const std::vector<double>& x, const std::vector<double>& y) {
  double sum = 0.0;
  for (std::size_t i = 0, n = x.size(); i < n; ++i) {
    const std::size_t a = (i + n - 1) % n, b = (i + 1) % n;
    const double before = std::hypot(x[i] - x[a], y[i] - y[a]);
    const double after = std::hypot(x[b] - x[i], y[b] - y[i]);
    const double turn =
        std::remainder(std::atan2(y[b] - y[i], x[b] - x[i]) - std::atan2(y[i] - y[a], x[i] - x[a]),
                       2 * std::numbers::pi);
    sum += turn * turn / (0.5 * (before + after));
  }
  return sum;
}

// Round a closed lap the integral of the squared curvature is least where the path is widest: with
// no straights, along the outer edge; a circle of radius R has 2 pi / R.
TEST(RacingLine, FollowsTheOuterEdgeOfACircle) {
  const crg::Surface surface(stadium(1e-3));
  const RacingLine line = plan_line(surface);
  ASSERT_TRUE(line.closed);
  for (const double v_m : line.v_m) EXPECT_NEAR(v_m, -5.0, 0.05);
  EXPECT_NEAR(bending(line.x_m, line.y_m) * 45.0 / (2 * std::numbers::pi), 1.0, 0.01);
}

// No other path on the road bends less: not by moving smoothly anywhere, by millimetres or metres.
TEST(RacingLine, BendsLeastOfAllPathsOnTheRoad) {
  const crg::Surface surface(stadium());
  const RacingLine line = plan_line(surface);
  const double least = bending(line.x_m, line.y_m);
  EXPECT_LT(least, 0.9 * 2 * std::numbers::pi / 40.0);  // that of the middle of the road
  const std::size_t n = line.v_m.size();
  std::mt19937 random(2);
  for (int trial = 0; trial < 3000; ++trial) {
    const std::size_t middle = random() % n;
    const double width = 1.0 + static_cast<double>(random() % 40);
    const double amount =
        (random() % 2 == 0 ? 1.0 : -1.0) * std::pow(10.0, -3.0 + static_cast<double>(random() % 4));
    std::vector<double> x = line.x_m, y = line.y_m;
    for (std::size_t i = 0; i < n; ++i) {
      double away = std::abs(static_cast<double>(i) - static_cast<double>(middle));
      away = std::min(away, static_cast<double>(n) - away) / width;
      const double v = std::clamp(line.v_m[i] + amount * std::exp(-away * away), -5.0, 5.0);
      const crg::Point2 at =
          surface.xy_of_uv(line.u_begin_m + line.u_step_m * static_cast<double>(i), v);
      x[i] = at.x_m;
      y[i] = at.y_m;
    }
    EXPECT_GE(bending(x, y), least * (1 - 1e-6)) << middle << " " << width << " " << amount;
  }
  for (const double v_m : line.v_m) EXPECT_LE(std::abs(v_m), 5.0 + 1e-9);
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

/// Speeds of the test's car on a line, without what depends on speed or warmth.
std::vector<double> speeds_on(RacingLine line, double road_grip) {
  const CarFiles files = test_car_files();
  Amplitudes<double> terms = default_amplitudes();
  terms[Term::aero_downforce] = terms[Term::aero_drag] = terms[Term::tyre_thermal] = 0.0;
  Parameters<double> parameters = default_parameters();
  parameters[Parameter::environment_road_grip] = road_grip;
  plan_speed(line, make_car(files, parameters, terms), {});
  return line.speed_mps;
}

TEST(RacingLine, IsAsFastAsTheRoadAllows) {
  const std::vector<double> dry = speeds_on(plan_line(crg::Surface(stadium())), 1.0),
                            wet = speeds_on(plan_line(crg::Surface(stadium())), 0.5);
  // In the turns the square of the speed goes with the grip.
  const double slowest = *std::min_element(dry.begin(), dry.end()),
               slowest_wet = *std::min_element(wet.begin(), wet.end());
  EXPECT_NEAR(slowest_wet * slowest_wet / (slowest * slowest), 0.5, 0.02);
  // A road that is as slippery as a wet day is no other thing.
  EXPECT_EQ(speeds_on(plan_line(crg::Surface(stadium(), {.friction = 0.5})), 1.0), wet);
}

TEST(RacingLine, AWetPatchIsSlowWhereTheCarRollsOverIt) {
  const crg::Crg road = stadium();
  crg::Crg grip = road;
  const std::size_t columns = grip.grid.v_m.size(), rows = grip.grid.rows();
  const double u_step_m = crg::integrate_reference_line(grip).u_step_m;
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) {
      const double u_m = static_cast<double>(i) * u_step_m;
      grip.grid.at(i, j) = u_m > 40.0 && u_m < 60.0 ? 0.4F : 1.0F;
    }
  const RacingLine line = plan_line(crg::Surface(road, {.friction_map = grip}));
  for (std::size_t i = 0; i < line.v_m.size(); ++i) {
    const double u_m = line.u_step_m * static_cast<double>(i);
    if (u_m > 40.0 && u_m < 60.0) {
      EXPECT_NEAR(line.friction[i], 0.4, 1e-6) << u_m;
    } else if (u_m < 37.0 || u_m > 63.0) {
      EXPECT_EQ(line.friction[i], 1.0) << u_m;
    }
  }
}

}  // namespace racing_line_test
