// The three contacts of a wheel with the road: what they agree on, and what a kerb shows.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "test_car.h"
#include "test_roads.h"
#include "vehicle/error.h"

namespace contact_test {

using namespace vehicle;  // NOLINT: a test of this library

TEST(Contact, AllSeeTheSamePlane) {
  const crg::Surface surface(
      straight(60.0, 0.1, [](double u, double v) { return 0.03 * u - 0.02 * v; }));
  const Road road(surface);
  const CarFiles files = test_car_files();
  StartOptions begin;
  begin.x_m = 30.0;
  begin.yaw_rad = 0.3;
  begin.speed_mps = 20.0;
  double expected = 0.0;
  for (const Contact contact : {Contact::kSinglePoint, Contact::kFourPoint, Contact::kStrip}) {
    const Car<double> car = make_car(files, default_parameters(), default_amplitudes(), contact);
    Simulation<double> sim = start(car, road, begin);
    Detail<double> detail;
    ASSERT_TRUE(step(car, sim, {}, road, {}, detail).ok());
    for (const auto& wheel : detail.wheel) {
      EXPECT_NEAR(wheel.road.dzdx, 0.03, 2e-5);
      EXPECT_NEAR(wheel.road.dzdy, -0.02, 2e-5);
    }
    if (contact == Contact::kSinglePoint) expected = detail.wheel[0].fz_n;
    EXPECT_NEAR(detail.wheel[0].fz_n, expected, 0.002 * expected);
  }
}

/// Largest load of the front left wheel while the car rolls at 20 m/s over a kerb with saw teeth.
double peak_load(Contact contact, const StripShape& strip) {
  const crg::Surface surface(straight(40.0, 0.05, [](double u, double) {
    if (u < 20.0 || u > 22.0) return 0.0;
    return 0.025 * (1.0 - std::cos(2.0 * std::numbers::pi * (u - 20.0) / 0.4)) / 2.0;
  }));
  const Road road(surface);
  const CarFiles files = test_car_files();
  const Car<double> car =
      make_car(files, default_parameters(), default_amplitudes(), contact, strip);
  StartOptions begin;
  begin.x_m = 12.0;
  begin.speed_mps = 20.0;
  begin.gear = 0;
  Simulation<double> sim = start(car, road, begin);
  Detail<double> detail;
  Controls<double> roll;
  roll.gear_command = 0;
  double peak = 0.0;
  for (int i = 0; i < 600; ++i) {
    EXPECT_TRUE(step(car, sim, roll, road, {}, detail).ok());
    peak = std::max(peak, detail.wheel[0].fz_n);
  }
  return peak;
}

TEST(Contact, StripsEnvelopAKerbAsAFinerStripDoesAndAPointDoesNot) {
  const double usual = peak_load(Contact::kStrip, {});
  // The same lengths: 1 cm with four times the samples, and 1 mm along on a narrow strip (the kerb
  // is the same everywhere across).
  const double four_times = peak_load(Contact::kStrip, {.along = 53, .across = 30, .step_m = 0.01});
  const double millimetre =
      peak_load(Contact::kStrip, {.along = 521, .across = 3, .step_m = 0.001});
  const double point = peak_load(Contact::kSinglePoint, {});
  EXPECT_NEAR(usual / four_times, 1.0, 0.03);
  EXPECT_NEAR(usual / millimetre, 1.0, 0.03);
  EXPECT_GT(std::abs(point / usual - 1.0), 0.1);
  RecordProperty("usual", std::to_string(usual));
  RecordProperty("four_times", std::to_string(four_times));
  RecordProperty("millimetre", std::to_string(millimetre));
  RecordProperty("point", std::to_string(point));
}

TEST(Contact, RowsThatCannotLiftACamAreNotMissed) {
  // A ridge, a step and a hole on a slope in both directions, looked at from everywhere.
  crg::Crg crg = straight(40.0, 0.1, [](double u, double v) {
    const double ridge = std::abs(u - 20.2) < 0.12 ? 0.08 : 0.0, step = u > 25.0 ? 0.12 : 0.0;
    return 0.05 * u - 0.06 * v + ridge + step + 0.004 * std::sin(9.0 * u + 4.0 * v);
  });
  const crg::Surface surface(crg);
  const Road road(surface);
  const StripShape shape;
  const Cams cams = make_cams(shape, 0.3, 0.1);
  Cams looks_everywhere = cams;
  looks_everywhere.near_begin = 0;
  looks_everywhere.near_end = shape.along;
  EXPECT_GT(cams.near_begin, 5u);
  EXPECT_LT(cams.near_end, shape.along - 5u);
  RoadCursors some, all;
  for (double u = 18.0; u < 27.0; u += 0.013) {
    const double v = 0.7 * std::sin(3.0 * u), z = surface.at_uv(u, v).z_m, turn = 5.0 * u;
    const crg::Point2 at = surface.xy_of_uv(u, v), heading{std::cos(turn), std::sin(turn)};
    const RoadPoint near = road.under_strip(at.x_m, at.y_m, z, heading, shape, cams, 0, some);
    const RoadPoint whole =
        road.under_strip(at.x_m, at.y_m, z, heading, shape, looks_everywhere, 0, all);
    ASSERT_EQ(near.z_m, whole.z_m) << u;
    ASSERT_EQ(near.dzdx, whole.dzdx) << u;
    ASSERT_EQ(near.dzdy, whole.dzdy) << u;
  }
}

TEST(Contact, RefusesStripsThatCannotBe) {
  const CarFiles files = test_car_files();
  for (const StripShape& bad : {StripShape{.along = 1}, StripShape{.along = 500, .across = 500},
                                StripShape{.step_m = 0.0}, StripShape{.cam_order = 0.5}})
    EXPECT_THROW(make_car(files, default_parameters(), default_amplitudes(), Contact::kStrip, bad),
                 Error);
}

}  // namespace contact_test
