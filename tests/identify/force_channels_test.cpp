// What is read of a log: noises, gears, and what is said where a channel stands for another.
#include "force_channels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "base/random.h"
#include "support/places.h"
#include "vehicle/vehicle_file.h"

namespace force_channels_test {

using namespace vehicle;  // NOLINT: names of one library

struct Racer {
  Vehicle vehicle = read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
  Car<double> car = make_car(vehicle.files, vehicle.parameters, vehicle.terms);
};

/// 2 s straight on in third gear, then fourth, at 100 Hz; extra channels as given.
recording::Table straight(const Racer& racer, const std::vector<std::string>& extra) {
  recording::Table t;
  for (const char* name : {"time_s", "x_m", "y_m", "yaw_rad", "vx_mps"}) t.add(name, {});
  for (const std::string& name : extra) t.add(name, {});
  base::Random random(1);
  for (int k = 0; k < 200; ++k) {
    const double time = 0.01 * k, v = 40.0 + 2.0 * time;
    const double wheel = v / 0.33;
    const int gear = k < 100 ? 3 : 4;
    for (std::size_t i = 0; i < t.names.size(); ++i) {
      const std::string& name = t.names[i];
      const double noise = random.normal();
      t.columns[i].push_back(name == "time_s"   ? time
                             : name == "x_m"    ? v * time
                             : name == "vx_mps" ? v + 0.05 * noise
                             : name == "engine_radps"
                                 ? wheel * overall_ratio(racer.car.parameters, gear)
                             : name == "gear"             ? gear
                             : name.starts_with("wheel_") ? wheel
                                                          : 1e-3 * noise);
    }
  }
  return t;
}

identify::ForceChannels read(const Racer& racer, const std::vector<std::string>& extra) {
  return identify::read_force_channels(recording::make_recording(straight(racer, extra), "log"),
                                       racer.car);
}

TEST(ForceChannels, NoiseIsThatOfWhiteNoiseOnASmoothCurve) {
  base::Random random(2);
  std::vector<double> values;
  for (int k = 0; k < 4000; ++k)
    values.push_back(k % 3 == 1 ? NAN : 20.0 * std::sin(0.01 * k) + 0.3 * random.normal());
  EXPECT_NEAR(identify::noise_of(values), 0.3, 0.02);
  EXPECT_EQ(identify::noise_of({1.0, 2.0, 3.0}), 0.0);
}

TEST(ForceChannels, GearIsToldBySpeedsWhereItWasNotRecorded) {
  const Racer racer;
  const auto channels = read(racer, {"steer_rad", "throttle", "brake_pa", "engine_radps",
                                     "wheel_rl_radps", "wheel_rr_radps"});
  EXPECT_EQ(channels.rows[50].driven.gear, 3);
  EXPECT_EQ(channels.rows[150].driven.gear, 4);
  // The log shows no neutral: the shift takes its time after the change.
  EXPECT_EQ(channels.rows[102].driven.gear, 0);
  EXPECT_EQ(channels.rows[102].driven.next_gear, 4);
  EXPECT_THAT(channels.said, ::testing::Contains(::testing::HasSubstr("speeds of engine and")));
  EXPECT_THAT(channels.said, ::testing::Contains(::testing::HasSubstr("at all wheels")));
}

TEST(ForceChannels, CommandsStandForWhatWasNotMeasured) {
  const Racer racer;
  const auto channels = read(racer, {"steer_command_rad", "throttle_command", "gear"});
  EXPECT_THAT(channels.said,
              ::testing::Contains(::testing::HasSubstr("steer_command_rad stands for")));
  EXPECT_THAT(channels.said, ::testing::Contains(::testing::HasSubstr("no brake pressure")));
  EXPECT_THROW(read(racer, {"throttle"}), base::Error);
}

TEST(ForceChannels, SaysHowManyRowsOfAReleasedPedalWereNoise) {
  const Racer racer;
  recording::Table t =
      straight(racer, {"steer_rad", "throttle", "brake_pa", "gear"});  // brake_pa: column 7
  base::Random random(3);
  for (double& pressure : t.columns[7]) pressure = std::max(0.0, 2e4 * random.normal());
  const auto read = [&] {
    return identify::read_force_channels(recording::make_recording(t, "log"), racer.car);
  };
  EXPECT_THAT(read().said, ::testing::Contains(::testing::ContainsRegex(
                               "brake_pa: [0-9]+ rows are taken as 0: noise whose other half")));
  for (double& pressure : t.columns[7]) pressure = 5e6;  // a foot that never leaves it
  EXPECT_THAT(read().said,
              ::testing::Not(::testing::Contains(::testing::HasSubstr("are taken as"))));
}

}  // namespace force_channels_test
