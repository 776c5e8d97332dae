#include "vehicle/signal_sensors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "support/temporary_folder.h"
#include "vehicle/error.h"

namespace signal_sensors_test {

using namespace vehicle;  // NOLINT: a test of this library
using ::testing::HasSubstr;

/// What one sensor tells of `truth(t)` at each step of 1 ms, and how old that is.
struct Told {
  std::vector<double> value, age_s;
};
template <class Truth>
Told told(const SignalSensor& sensor, int steps, const Truth& truth, std::uint64_t seed = 1) {
  SignalSensors sensors({seed, {sensor}, {}, {}}, 0.001);
  Told out;
  for (int k = 0; k < steps; ++k) {
    sensors.step(std::array{truth(0.001 * k)});
    out.value.push_back(sensors.value(0));
    out.age_s.push_back(sensors.age_s(0));
  }
  return out;
}

SignalSensor sensor(double rate_hz = 0.0) {
  SignalSensor out;
  out.name = "imu.yaw_rate";
  out.signal = "car.yaw_rate";
  out.rate_hz = rate_hz;
  return out;
}

double zero(double) { return 0.0; }

double deviation(const std::vector<double>& values) {
  double mean = 0.0, square = 0.0;
  for (const double x : values) mean += x / static_cast<double>(values.size());
  for (const double x : values)
    square += (x - mean) * (x - mean) / static_cast<double>(values.size());
  return std::sqrt(square);
}

/// One value per sample.
std::vector<double> every(const std::vector<double>& values, std::size_t steps) {
  std::vector<double> out;
  for (std::size_t k = 0; k < values.size(); k += steps) out.push_back(values[k]);
  return out;
}

constexpr int kTenMinutes = 600'000;

TEST(SignalSensors, WhiteNoiseOfTenMinutesIsThatOfTheFile) {
  SignalSensor white = sensor(100.0);
  white.noise = 0.02;
  EXPECT_NEAR(deviation(every(told(white, kTenMinutes, zero).value, 10)), 0.02, 0.05 * 0.02);
  // A data sheet: 0.003 deg/s/sqrt(Hz), sampled at 100 Hz.
  SignalSensor dense = sensor(100.0);
  dense.noise_density = 0.003;
  EXPECT_NEAR(deviation(every(told(dense, kTenMinutes, zero).value, 10)), 0.03, 0.05 * 0.03);
}

TEST(SignalSensors, TheBiasWalksAsFarAsTheFileSays) {
  SignalSensor walks = sensor(10.0);
  walks.bias_walk = 0.01;  // after 16 s 0.04
  double square = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 64; ++seed) {
    const std::vector<double> value = told(walks, 96'000, zero, seed).value;
    EXPECT_EQ(value.front(), 0.0);
    for (std::size_t k = 16'000; k < value.size(); k += 16'000, ++count)
      square += std::pow(value[k] - value[k - 16'000], 2);
  }
  EXPECT_NEAR(std::sqrt(square / count), 0.04, 0.1 * 0.04);
}

TEST(SignalSensors, AnUnstableBiasStaysWithinItsDeviationAndForgetsItself) {
  SignalSensor unstable = sensor(10.0);
  unstable.bias_instability = 0.5;
  unstable.bias_time_s = 3.0;
  double now = 0.0, product = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 64; ++seed) {
    const std::vector<double> value = told(unstable, 90'000, zero, seed).value;
    for (std::size_t k = 0; k + 3'000 < value.size(); k += 3'000, ++count) {
      now += value[k] * value[k];
      product += value[k] * value[k + 3'000];
    }
  }
  EXPECT_NEAR(std::sqrt(now / count), 0.5, 0.05);
  EXPECT_NEAR(product / now, std::exp(-1.0), 0.05);
}

TEST(SignalSensors, ASampleIsThatOfTheDelayBefore) {
  SignalSensor late = sensor(100.0);
  late.delay_s = 0.025;
  const Told ramp = told(late, 200, [](double t_s) { return 3.0 + t_s; });
  EXPECT_EQ(ramp.value[10], 3.0) << "as it was at the begin";
  EXPECT_NEAR(ramp.value[100], 3.0 + 0.075, 1e-12);
  EXPECT_EQ(ramp.value[109], ramp.value[100]) << "held until the next sample";
  EXPECT_NEAR(ramp.value[110], 3.0 + 0.085, 1e-12);
  EXPECT_NEAR(ramp.age_s[100], 0.025, 1e-12);
  EXPECT_NEAR(ramp.age_s[109], 0.034, 1e-12);
}

TEST(SignalSensors, JitterDelaysSamplesAndLostOnesLeaveTheLast) {
  SignalSensor jitters = sensor(50.0);
  jitters.jitter_s = 0.010;
  const Told clock = told(jitters, 100'000, [](double t_s) { return t_s; });
  std::vector<double> late_s;
  for (std::size_t k = 1; k < clock.value.size(); ++k)
    if (clock.value[k] != clock.value[k - 1])
      late_s.push_back(std::fmod(clock.value[k] + 1e-9, 0.020));
  ASSERT_EQ(late_s.size(), 4999u) << "jitter loses none";
  double mean = 0.0, largest = 0.0;
  for (const double late : late_s) mean += late / 4999.0, largest = std::max(largest, late);
  EXPECT_NEAR(mean, 0.005, 0.0005);
  EXPECT_LE(largest, 0.0106);

  SignalSensor loses = sensor(100.0);
  loses.lost = 0.3;
  const Told gaps = told(loses, 100'000, [](double t_s) { return t_s; });
  std::size_t arrived = 0;
  for (std::size_t k = 1; k < gaps.value.size(); ++k) arrived += gaps.value[k] != gaps.value[k - 1];
  EXPECT_NEAR(static_cast<double>(arrived) / 10'000.0, 0.7, 0.02);
}

TEST(SignalSensors, WhatOneDeviceTellsComesTogether) {
  SignalSensor x = sensor(20.0), y = sensor(20.0), other = sensor(20.0);
  x.name = "gnss.x", y.name = "gnss.y", other.name = "imu.ax";
  for (SignalSensor* one : {&x, &y, &other}) one->jitter_s = 0.02, one->lost = 0.2;
  SignalSensors sensors({3, {x, y, other}, {}, {}}, 0.001);
  int apart = 0;
  for (int k = 0; k < 20'000; ++k) {
    const double t_s = 0.001 * k;
    sensors.step(std::array{t_s, t_s, t_s});
    ASSERT_EQ(sensors.value(0), sensors.value(1));
    apart += sensors.value(0) != sensors.value(2);
  }
  EXPECT_GT(apart, 2000);
}

TEST(SignalSensors, GainOffsetStepsAndLimits) {
  SignalSensor is = sensor();
  is.gain = -2.0;
  is.offset = 1.0;
  is.quantisation = 0.25;
  is.smallest = -3.0;
  is.largest = 3.0;
  const auto ramp = told(is, 3001, [](double t_s) { return t_s; }).value;
  EXPECT_EQ(ramp[0], 1.0);
  EXPECT_EQ(ramp[100], 0.75);  // 0.8
  EXPECT_EQ(ramp[3000], -3.0) << "-5";
}

TEST(SignalSensors, ASensorDoesNotChangeAnotherOnesNoise) {
  SignalSensor first = sensor(100.0), second = sensor(100.0);
  first.noise = second.noise = 1.0;
  second.name = "other";
  SignalSensors alone({7, {first}, {}, {}}, 0.001), both({7, {second, first}, {}, {}}, 0.001);
  for (int k = 0; k < 100; ++k) {
    alone.step(std::array{0.0});
    both.step(std::array{0.0, 0.0});
    EXPECT_EQ(alone.value(0), both.value(1));
  }
  EXPECT_NE(both.value(0), both.value(1));
}

TEST(SignalSensors, CommandsAreScaledAndHeldWithinTheirLimits) {
  const support::TemporaryFolder folder;
  const SignalSensorFile file = read_signal_sensors(
      folder.file("d.yaml",
                  "commands:\n  throttle_percent: {signal: input.throttle, gain: 0.01, smallest: "
                  "0, largest: 1}\n"
                  "  steer_right_deg: {signal: input.steering, gain: -0.0174533}\n"));
  ASSERT_EQ(file.commands.size(), 2u);
  EXPECT_EQ(file.commands[0].signal, "input.throttle");
  EXPECT_DOUBLE_EQ(file.commands[0].to_signal(40.0), 0.4);
  EXPECT_EQ(file.commands[0].to_signal(140.0), 1.0);
  EXPECT_DOUBLE_EQ(file.commands[1].to_signal(10.0), -0.174533);
  EXPECT_DOUBLE_EQ(file.commands[1].from_signal(-0.174533), 10.0);
}

TEST(SignalSensors, TopicsTellFieldsInTheOrderOfTheFile) {
  const support::TemporaryFolder folder;
  const SignalSensorFile file = read_signal_sensors(
      folder.file("d.yaml",
                  "topics:\n  imu/data: {type: sensor_msgs/Imu, frame: imu, fields: "
                  "{angular_velocity.z: car.yaw_rate, angular_velocity.variance: 0.5}}\n"));
  ASSERT_EQ(file.topics.size(), 1u);
  EXPECT_EQ(file.topics[0].name, "imu/data");
  EXPECT_EQ(file.topics[0].type, "sensor_msgs/Imu");
  EXPECT_EQ(file.topics[0].frame, "imu");
  EXPECT_EQ(file.topics[0].child_frame, "base_link");
  using Field = std::pair<std::string, std::string>;
  EXPECT_EQ(file.topics[0].fields, (std::vector{Field{"angular_velocity.z", "car.yaw_rate"},
                                                Field{"angular_velocity.variance", "0.5"}}));
}

std::string refusal(const std::string& yaml) {
  const support::TemporaryFolder folder;
  try {
    SignalSensors(read_signal_sensors(folder.file("s.yaml", yaml)), 0.001);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(SignalSensors, RefusesWithThePlace) {
  EXPECT_EQ(refusal("sensors:\n  a: {signal: car.x, rate_hz: 10, noise: 0.3}\n"), "");
  EXPECT_THAT(refusal("sensors:\n  a: {signal: car.x, rate: 10}\n"), HasSubstr("s.yaml:2"));
  EXPECT_THAT(refusal("sensors:\n  a: {noise: 1}\n"), HasSubstr("signal"));
  EXPECT_THAT(refusal("sensors: {}\n"),
              HasSubstr("no sensor, no command, no topic, no scan and no edges"));
  EXPECT_THAT(refusal("commands:\n  a: {signal: x, gain: 0}\n"),
              HasSubstr("s.yaml:2: a: a gain of 0"));
  EXPECT_THAT(refusal("sensors:\n  a: {signal: x, smallest: 2, largest: 1}\n"),
              HasSubstr("s.yaml:2: a: smallest has to be below largest"));
  EXPECT_THAT(refusal("sensors:\n  a: {signal: x, rate_hz: 100, jitter_s: 0.01}\n"),
              HasSubstr("jitter_s has to be less"));
  EXPECT_THAT(refusal("sensors:\n  a: {signal: x, rate_hz: 2000}\n"),
              HasSubstr("at most one sample per step"));
  EXPECT_THAT(refusal("sensors:\n  a: {signal: x}\npositions:\n  p: {x: a, y: b}\n"),
              HasSubstr("s.yaml:4: there is no sensor 'b'"));
  EXPECT_THAT(refusal("sensors:\n  a: {signal: x, noise: .nan}\n"), HasSubstr("noise"));
  EXPECT_THAT(refusal("topics:\n  t: {type: a/B, fields: {x: [1, 2]}}\n"),
              HasSubstr("s.yaml:2: x is no name and no number"));
  EXPECT_THAT(refusal("topics:\n  t: {type: a/B}\n"), HasSubstr("fields"));
}

}  // namespace signal_sensors_test
