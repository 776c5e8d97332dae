// Throttle and brakes between rows.
#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "pedals.h"

namespace feet_test {

using identify::kPlaceBrake, identify::kPlaceThrottle;

// 2 s at 50 Hz: a throttle that rests for a second, then opens by a half; a pressure without noise
// that falls, recorded in every other row; the other pressures are not recorded.
TEST(Feet, MoveBetweenRowsAsTheirChannelsDo) {
  recording::Table log;
  for (const char* name : {"time_s", "x_m", "y_m", "yaw_rad", "vx_mps"}) log.add(name, {});
  identify::ForceChannels channels;
  channels.sensors = {{"throttle", false, kPlaceThrottle}, {"brake_fl_pa", false, kPlaceBrake}};
  channels.sensors[0].deviation = 0.002;
  base::Random random(4);
  for (int k = 0; k < 100; ++k) {
    const double time = 0.02 * k, throttle = 0.3 + 0.5 * std::max(0.0, time - 1.0);
    for (std::size_t i = 0; i < log.columns.size(); ++i)
      log.columns[i].push_back(i == 0 ? time : 0);
    identify::SmootherRow row;
    row.time_s = time;
    row.noise = identify::PlaceVector::Constant(1e-2);
    row.measured = {{0, throttle + 0.002 * random.normal()}};
    if (k % 2 == 0) row.measured.push_back({1, 1e6 - 4e5 * time});
    channels.rows.push_back(row);
  }
  identify::move_feet(recording::make_recording(log, "log"), channels);
  const auto foot = [&](std::size_t row, std::size_t place) {
    return channels.rows[row].driven.feet_per_s[place - kPlaceThrottle];
  };
  double rests = 0.0, opens = 0.0;
  for (std::size_t k = 10; k < 40; ++k) rests += foot(k, kPlaceThrottle) / 30.0;
  for (std::size_t k = 60; k < 90; ++k) opens += foot(k, kPlaceThrottle) / 30.0;
  EXPECT_NEAR(rests, 0.0, 0.02);
  EXPECT_NEAR(opens, 0.5, 0.1);
  EXPECT_NEAR(foot(20, kPlaceBrake), -4e5, 1.0);
  EXPECT_NEAR(foot(21, kPlaceBrake), -4e5, 1.0);
  EXPECT_EQ(foot(20, kPlaceBrake + 1), 0.0);
  // What comes in otherwise: the square of its steps, little at rest, all where none is recorded.
  EXPECT_NEAR(channels.rows[70].noise[kPlaceThrottle], 1e-4, 5e-5);
  EXPECT_NEAR(channels.rows[20].noise[kPlaceThrottle], 1e-4, 2e-5);
  EXPECT_NEAR(channels.rows[20].noise[kPlaceBrake], 8e3 * 8e3, 1.0);
  EXPECT_EQ(channels.rows[20].noise[kPlaceBrake + 1], 1e-2);
}

}  // namespace feet_test
