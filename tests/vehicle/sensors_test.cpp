#include "vehicle/sensors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include "base/write_file.h"
#include "recording/channels.h"
#include "support/places.h"
#include "vehicle/error.h"
#include "vehicle/manoeuvre.h"
#include "vehicle/vehicle_file.h"

namespace sensors_test {

using namespace vehicle;  // NOLINT: a test of this library
using ::testing::HasSubstr;

std::size_t column(const std::string& name) {
  const auto& names = recording::telemetry_channels();
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

/// Runs `steps` steps of 1 ms with the given channel values, a row every 10.
template <class F>
recording::Table run(const DeviceFile& file, int steps, F&& values, std::size_t every = 10) {
  SensorRecorder recorder(file, every, 0.001);
  for (int i = 0; i < steps; ++i) {
    std::vector<double> row(recording::telemetry_channels().size(), 0.0);
    row[0] = 0.001 * i;
    values(row, 0.001 * i);
    recorder.record(row, 0.0);
  }
  return recorder.table();
}

Device device(const std::string& channel) {
  Device d;
  d.name = "box";
  d.channels = {{channel}};
  return d;
}

TEST(Sensors, ScaleOffsetQuantiseDelayAndFilter) {
  const auto ramp = [](std::vector<double>& row, double t) { row[column("fz_fl_n")] = 1000 * t; };
  DeviceFile file;
  file.devices = {device("fz_fl_n")};
  file.devices[0].channels[0] = {"fz_fl_n", 2.0, 5.0, 0.0, 4.0};
  recording::Table t = run(file, 100, ramp);
  EXPECT_DOUBLE_EQ((*t.find("fz_fl_n"))[3], 64);  // 2 * 30 + 5 = 65, in steps of 4
  // A ramp through a delay of 12.5 ms and a filter of 1/(2 pi 10 Hz), settled: late by both.
  file.devices[0].channels[0] = {"fz_fl_n"};
  file.devices[0].delay_s = 0.0125;
  EXPECT_NEAR((*run(file, 100, ramp).find("fz_fl_n"))[8], 80 - 12.5, 1e-9);
  file.devices[0].low_pass_hz = 10;
  const double late_ms = 12.5 + 1000 / (2 * std::numbers::pi * 10);
  // The filter looks at the beginning of each step: up to half a millisecond.
  EXPECT_NEAR(run(file, 1000, ramp).find("fz_fl_n")->back(), 990 - late_ms, 0.6);
}

TEST(Sensors, SampleAtTheirOwnRateAndHoldOrLeaveEmpty) {
  const auto ramp = [](std::vector<double>& row, double t) { row[column("fz_fl_n")] = t; };
  DeviceFile file;
  file.devices = {device("fz_fl_n")};
  file.devices[0].rate_hz = 20;  // every fifth row
  file.others_ideal = false;
  recording::Table t = run(file, 200, ramp);
  const std::vector<double>& empty = *t.find("fz_fl_n");
  for (std::size_t i = 0; i < empty.size(); ++i)
    if (i % 5 == 0)
      EXPECT_NEAR(empty[i], 0.01 * static_cast<double>(i), 1e-12);
    else
      EXPECT_TRUE(std::isnan(empty[i]));
  EXPECT_EQ(t.find("vx_mps"), nullptr);
  EXPECT_NE(t.find("steer_command_rad"), nullptr);
  file.hold = true;
  t = run(file, 200, ramp);
  EXPECT_NEAR((*t.find("fz_fl_n"))[9], 0.05, 1e-12);
}

TEST(Sensors, NoiseHasItsWidthIsRepeatedAndDependsOnTheSeedAndTheChannelOnly) {
  DeviceFile file;
  file.devices = {device("ax_mps2")};
  file.devices[0].channels[0].noise = 0.5;
  const auto nothing = [](std::vector<double>&, double) {};
  const std::vector<double> a = *run(file, 20000, nothing, 1).find("ax_mps2");
  double sum = 0, squares = 0, next = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += a[i];
    squares += a[i] * a[i];
    if (i > 0) next += a[i] * a[i - 1];
  }
  const auto n = static_cast<double>(a.size());
  EXPECT_NEAR(sum / n, 0, 4 * 0.5 / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(squares / n), 0.5, 4 * 0.5 / std::sqrt(2 * n));
  EXPECT_NEAR(next / squares, 0, 4 / std::sqrt(n));
  EXPECT_EQ(*run(file, 20000, nothing, 1).find("ax_mps2"), a);
  DeviceFile more = file;
  more.devices.insert(more.devices.begin(), device("vx_mps"));
  more.devices[0].channels[0].noise = 0.1;
  EXPECT_EQ(*run(more, 20000, nothing, 1).find("ax_mps2"), a);
  file.seed = 2;
  EXPECT_NE(*run(file, 20000, nothing, 1).find("ax_mps2"), a);
}

// A car turning on the spot at w with growing w: what a box 2 m ahead and 1 m up measures is known.
TEST(Sensors, FeelTheirPlaceAndAxes) {
  constexpr double kGrowth = 0.5, kYaw = 0.3;
  DeviceFile file;
  Device box = device("ax_mps2");
  for (const char* name : {"ay_mps2", "az_mps2", "vx_mps", "vy_mps", "x_m", "y_m", "z_m",
                           "roll_rate_radps", "pitch_rate_radps", "yaw_rate_radps", "yaw_rad"})
    box.channels.push_back({name});
  box.lever_arm_m = {2, 0, 1};
  box.mounting_rad = {0, 0, kYaw};
  file.devices = {box};
  const recording::Table t = run(file, 1000, [&](std::vector<double>& row, double time) {
    row[column("yaw_rate_radps")] = kGrowth * time;
    row[column("yaw_rad")] = 0.5 * kGrowth * time * time;
    row[column("az_mps2")] = 9.81;
  });
  const std::size_t i = 80;
  const double w = kGrowth * 0.8, yaw = 0.5 * kGrowth * 0.64;
  const double forward = -2 * w * w, left = 2 * kGrowth;
  EXPECT_NEAR((*t.find("ax_mps2"))[i], std::cos(kYaw) * forward + std::sin(kYaw) * left, 1e-9);
  EXPECT_NEAR((*t.find("ay_mps2"))[i], -std::sin(kYaw) * forward + std::cos(kYaw) * left, 1e-9);
  EXPECT_NEAR((*t.find("az_mps2"))[i], 9.81, 1e-9);
  EXPECT_NEAR((*t.find("vx_mps"))[i], std::sin(kYaw) * 2 * w, 1e-9);
  EXPECT_NEAR((*t.find("vy_mps"))[i], std::cos(kYaw) * 2 * w, 1e-9);
  EXPECT_NEAR((*t.find("x_m"))[i], 2 * std::cos(yaw), 1e-9);
  EXPECT_NEAR((*t.find("y_m"))[i], 2 * std::sin(yaw), 1e-9);
  EXPECT_NEAR((*t.find("z_m"))[i], 1, 1e-9);
  EXPECT_NEAR((*t.find("yaw_rad"))[i], yaw + kYaw, 1e-9);
  EXPECT_NEAR((*t.find("yaw_rate_radps"))[i], w, 1e-9);
}

TEST(Sensors, ComeFromAFileThatIsCheckedAndMeasureAManoeuvre) {
  const std::string path = (std::filesystem::temp_directory_path() /
                            ("kerbstone_devices_" + std::to_string(::getpid()) + ".yaml"))
                               .string();
  const auto refusal = [&](const std::string& text) -> std::string {
    base::write_file(path, text);
    try {
      read_devices(path);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal("devices: {a: {channels: {speed: }}}\n"), HasSubstr("no channel 'speed'"));
  EXPECT_THAT(refusal("devices: {a: {channels: {vx_mps: {noise: -1}}}}\n"), HasSubstr("noise"));
  EXPECT_THAT(refusal("devices: {a: {rate: 5, channels: {vx_mps: }}}\n"), HasSubstr("'rate'"));
  EXPECT_THAT(refusal("devices: {a: {lever_arm_m: [1, 2], channels: {vx_mps: }}}\n"),
              HasSubstr("wanted 3"));
  EXPECT_THAT(refusal("devices:\n a: {channels: {vx_mps: }}\n b: {channels: {vx_mps: }}\n"),
              HasSubstr(":3: vx_mps is measured twice"));
  EXPECT_THAT(refusal("devices: {a: {channels: {}}}\n"), HasSubstr("measures nothing"));
  EXPECT_THAT(refusal("between_samples: maybe\ndevices: {}\n"), HasSubstr("empty or hold"));
  std::filesystem::remove(path);

  const std::string root = places::source();
  const DeviceFile file = read_devices(root + "/vehicles/open_wheel/devices.yaml");
  const Vehicle v = read_vehicle(root + "/vehicles/open_wheel/vehicle.yaml");
  const Car<double> car = make_car(v.files, v.parameters, v.terms);
  Manoeuvre m;
  m.record_every = 10;
  m.duration_s = 3;
  const recording::Table ideal = run_manoeuvre(car, m).telemetry;
  m.devices = &file;
  const recording::Table measured = run_manoeuvre(car, m).telemetry;
  ASSERT_EQ(measured.rows(), ideal.rows());
  EXPECT_EQ(*measured.find("steer_command_rad"), *ideal.find("steer_command_rad"));
  EXPECT_NE(*measured.find("yaw_rate_radps"), *ideal.find("yaw_rate_radps"));
  double worst = 0;
  for (std::size_t i = 0; i < ideal.rows(); ++i)
    worst = std::max(worst, std::abs((*measured.find("yaw_rate_radps"))[i] -
                                     (*ideal.find("yaw_rate_radps"))[i]));
  EXPECT_LT(worst, 0.1);
}

}  // namespace sensors_test
