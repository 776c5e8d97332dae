#include "vehicle/laws/steering.h"

#include <ceres/jet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/places.h"
#include "test_car.h"
#include "vehicle/error.h"
#include "vehicle/manoeuvre.h"
#include "vehicle/vehicle_file.h"

namespace steering_test {

using namespace vehicle;  // NOLINT: a test of this library
using P = Parameter;

// A rack that grows quicker off centre: 15 degrees of road wheel by 200 of the steering wheel, 30
// by 320, and a little less to the right.
Map1 rack() { return {{-5.0, -3.5, 0.0, 3.5, 5.6}, {-0.44, -0.25, 0.0, 0.26, 0.52}}; }

TEST(Steering, RatioIsThatOfTheMapByHand) {
  EXPECT_DOUBLE_EQ(laws::road_wheel_angle(rack(), 1.0, 1.75), 0.13);
  EXPECT_DOUBLE_EQ(laws::road_wheel_angle(rack(), 1.0, 4.55), 0.39);
  EXPECT_DOUBLE_EQ(laws::road_wheel_angle(rack(), 1.0, -1.75), -0.125);
  EXPECT_DOUBLE_EQ(laws::road_wheel_angle(rack(), 1.3, 4.55), 0.3);
  EXPECT_DOUBLE_EQ(laws::road_wheel_angle(rack(), 1.0, 9.0), 0.52);    // at its stop
  EXPECT_DOUBLE_EQ(laws::road_wheel_angle(rack(), 1.0, -9.0), -0.44);  // and the other
  EXPECT_EQ(laws::road_wheel_angle(Map1{}, 14.0, 0.7), 0.7 / 14.0);
}

TEST(Steering, CommandForAnAngleIsTheWayBack) {
  for (double angle = -0.43; angle < 0.52; angle += 0.01) {
    const double command = laws::steering_command(rack(), 1.1, angle / 1.1);
    EXPECT_NEAR(laws::road_wheel_angle(rack(), 1.1, command), angle / 1.1, 1e-14);
  }
  EXPECT_EQ(laws::steering_command(rack(), 1.0, 1.0), 5.6);
  EXPECT_EQ(laws::steering_command(rack(), 1.0, -1.0), -5.0);
  EXPECT_EQ(laws::steering_command(Map1{}, 14.0, 0.05), 14.0 * 0.05);
}

TEST(Steering, DifferentiatesExactly) {
  using Jet = ceres::Jet<double, 2>;
  const Jet out = laws::road_wheel_angle(rack(), Jet(1.3, 0), Jet(4.55, 1));
  EXPECT_NEAR(out.v[0], -0.39 / (1.3 * 1.3), 1e-15);
  EXPECT_NEAR(out.v[1], 0.26 / 2.1 / 1.3, 1e-15);
}

// The car with the map, asked by the steering wheel, gets the angle that the map has; asked for an
// angle of the road wheels (a step steer), it moves as the car with a constant ratio does.
TEST(Steering, CarTurnsItsRoadWheelsByTheMap) {
  CarFiles files = test_car_files();
  Parameters<double> p = default_parameters();
  Amplitudes<double> terms = default_amplitudes();
  for (const Term off : {Term::steering_actuator, Term::steering_friction}) terms[off] = 0.0;
  Manoeuvre m;
  m.kind = manoeuvre_named("step-steer");
  m.speed_mps = 20.0;
  m.steer_rad = 0.03;
  m.duration_s = 3.0;
  const ManoeuvreResult constant = run_manoeuvre(make_car(files, p, terms), m);
  files.steering = rack();
  const Car<double> car = make_car(files, p, terms);
  const ManoeuvreResult mapped = run_manoeuvre(car, m);
  EXPECT_NEAR(mapped.telemetry.find("steer_command_rad")->back(), 0.03 * 3.5 / 0.26, 1e-12);
  EXPECT_NEAR(mapped.telemetry.find("steer_rad")->back(), 0.03, 1e-12);
  EXPECT_NEAR(mapped.peak_yaw_rate_radps, constant.peak_yaw_rate_radps, 1e-9);
  Discrete<double> d{};
  Controls<double> c;
  c.steer_command_rad = 4.55;
  EXPECT_DOUBLE_EQ(actuate(car, d, c, 0.001).steer_rad, 0.39);
}

TEST(Steering, MapsThatCannotBeAreRefused) {
  const auto refused = [](Map1 map, double ratio, const char* part) {
    CarFiles files = test_car_files();
    files.steering = std::move(map);
    Parameters<double> p = default_parameters();
    p[P::steering_ratio] = ratio;
    EXPECT_THAT([&] { make_car(files, p, default_amplitudes()); },
                ::testing::ThrowsMessage<Error>(::testing::HasSubstr(part)));
  };
  refused({{-1, 0, 1}, {-0.1, 0.1, 0.1}}, 1.0, "must ascend");
  refused({{0.5, 1}, {0.1, 0.2}}, 1.0, "straight ahead");
  refused({{0}, {0}}, 1.0, "two places");
  refused({{-5, 0, 5}, {-2.5, 0, 0.5}}, 1.0, "right angle");
  refused(rack(), 14.0, "steering.ratio = 14");
}

}  // namespace steering_test
