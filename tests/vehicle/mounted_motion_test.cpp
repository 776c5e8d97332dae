// What sensors with a place and axes in the car tell, against the way of that place on the map.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "support/temporary_folder.h"
#include "vehicle/error.h"
#include "vehicle/signal_sensors.h"

namespace mounted_motion_test {

using namespace vehicle;  // NOLINT: a test of this library
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kStep_s = 0.001;

/// Sensors of all the car's numbers in one box.
SignalSensorFile box(const std::array<double, 3>& at_m, const std::array<double, 3>& turned_rad,
                     const std::vector<std::string>& signals) {
  SignalSensorFile file;
  for (const std::string& signal : signals) {
    SignalSensor sensor;
    sensor.name = "box." + signal;
    sensor.signal = signal;
    sensor.mounting = Mounting{at_m, turned_rad};
    file.sensors.push_back(sensor);
  }
  return file;
}

/// A car that slides, turns and changes both, on a plane.
struct Driven {
  double x_m, y_m, yaw_rad;
  static Driven at(double t_s) {
    return {12.0 * t_s + 2.0 * std::sin(1.3 * t_s), 0.8 * t_s * t_s - std::cos(t_s),
            0.4 * t_s + 0.3 * std::sin(2.1 * t_s)};
  }
};

/// Central differences of what a function of time says.
template <class F>
std::array<double, 2> rates(const F& of, double t_s) {
  constexpr double kH_s = 1e-3;
  const double before = of(t_s - kH_s), now = of(t_s), after = of(t_s + kH_s);
  return {(after - before) / (2.0 * kH_s), (after - 2.0 * now + before) / (kH_s * kH_s)};
}

std::array<double, 2> in_axes(double ahead, double left, double yaw_rad) {
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  return {c * ahead + s * left, -s * ahead + c * left};
}

TEST(MountedMotion, IsThatOfThePlaceOnTheMap) {
  const std::array arm_m{1.7, -0.6, 0.0};
  const double turned_rad = 0.25;
  const SignalSensorFile file =
      box(arm_m, {0.0, 0.0, turned_rad},
          {"car.x", "car.y", "car.yaw", "car.vx", "car.vy", "car.yaw_rate", "car.ax", "car.ay"});
  ASSERT_THAT(SignalSensors::signals(file),
              ElementsAre("car.x", "car.y", "car.yaw", "car.vx", "car.vy", "car.yaw_rate", "car.ax",
                          "car.ay", "car.x", "car.y", "car.z", "car.roll", "car.pitch", "car.yaw",
                          "car.vx", "car.vy", "car.roll_rate", "car.pitch_rate", "car.yaw_rate",
                          "car.ax", "car.ay", "car.az"));
  SignalSensors sensors(file, kStep_s);
  const auto x = [](double t_s) { return Driven::at(t_s).x_m; };
  const auto y = [](double t_s) { return Driven::at(t_s).y_m; };
  const auto yaw = [](double t_s) { return Driven::at(t_s).yaw_rad; };
  const auto box_x = [&](double t_s) {
    return x(t_s) + std::cos(yaw(t_s)) * arm_m[0] - std::sin(yaw(t_s)) * arm_m[1];
  };
  const auto box_y = [&](double t_s) {
    return y(t_s) + std::sin(yaw(t_s)) * arm_m[0] + std::cos(yaw(t_s)) * arm_m[1];
  };
  for (int k = 0; k < 3000; ++k) {
    const double t_s = kStep_s * k, psi = yaw(t_s), rate = rates(yaw, t_s)[0];
    const auto v = in_axes(rates(x, t_s)[0], rates(y, t_s)[0], psi);
    const auto a = in_axes(rates(x, t_s)[1], rates(y, t_s)[1], psi);
    sensors.step(std::array{x(t_s), y(t_s), psi,  v[0], v[1], rate, a[0], a[1],
                            x(t_s), y(t_s), 0.3,  0.0,  0.0,  psi,  v[0], v[1],
                            0.0,    0.0,    rate, a[0], a[1], 9.81});
    if (k == 0) continue;  // nothing is known yet of how the turning changes
    const auto speed = in_axes(rates(box_x, t_s)[0], rates(box_y, t_s)[0], psi + turned_rad);
    const auto felt = in_axes(rates(box_x, t_s)[1], rates(box_y, t_s)[1], psi + turned_rad);
    ASSERT_NEAR(sensors.value(0), box_x(t_s), 1e-9);
    ASSERT_NEAR(sensors.value(1), box_y(t_s), 1e-9);
    ASSERT_NEAR(sensors.value(2), psi + turned_rad, 1e-9);
    ASSERT_NEAR(sensors.value(3), speed[0], 1e-5);
    ASSERT_NEAR(sensors.value(4), speed[1], 1e-5);
    ASSERT_NEAR(sensors.value(5), rate, 1e-9);
    // The turning's change is that over the last step: half a step late, 2e-3 rad/s2 here.
    ASSERT_NEAR(sensors.value(6), felt[0], 4e-3) << t_s;
    ASSERT_NEAR(sensors.value(7), felt[1], 4e-3) << t_s;
  }
}

TEST(MountedMotion, ABoxThatLeansFeelsGravityInItsAxes) {
  // Nose down by a hundredth: of what pushes up, ahead is what the nose looks away from.
  SignalSensors sensors(box({}, {0.0, 0.01, 0.0}, {"car.ax", "car.az"}), kStep_s);
  sensors.step(std::array{0.0, 9.81, 0.0, 0.0, 0.0, 0.0, 0.0, 9.81});
  EXPECT_NEAR(sensors.value(0), -9.81 * std::sin(0.01), 1e-12);
  EXPECT_NEAR(sensors.value(1), 9.81 * std::cos(0.01), 1e-12);
}

std::string refusal(const std::string& yaml) {
  const support::TemporaryFolder folder;
  try {
    SignalSensors(read_signal_sensors(folder.file("s.yaml", yaml)), kStep_s);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(MountedMotion, WhatNoPlaceChangesIsRefused) {
  EXPECT_EQ(refusal("sensors:\n  a: {signal: car.ay, at_m: [0.4, 0, 0.1]}\n"), "");
  EXPECT_THAT(refusal("sensors:\n  a: {signal: engine.speed, at_m: [0.4, 0, 0.1]}\n"),
              HasSubstr("the sensor a has a place or axes in the car (at_m, turned_deg), which "
                        "change nothing of engine.speed; wanted one of car.x, car.y"));
  EXPECT_EQ(refusal("sensors:\n  a: {signal: body.acc_y, turned_deg: [0, 0, 1]}\n"
                    "pose: {ay: body.acc_y}\n"),
            "");
  EXPECT_THAT(refusal("sensors:\n  a: {signal: car.ay, at_m: [0.4, 0]}\n"), HasSubstr("at_m"));
  EXPECT_THAT(refusal("sensors:\n  a: {signal: car.ay, at_m: [400, 0, 0]}\n"),
              HasSubstr("at_m has 400"));
}

}  // namespace mounted_motion_test
