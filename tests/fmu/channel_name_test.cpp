#include "fmu/channel_name.h"

#include <gtest/gtest.h>

namespace channel_name_test {

TEST(ChannelName, TakesUnitAndWheelOut) {
  const auto expect = [](const char* channel, const char* name, const char* unit, bool of_wheel) {
    const fmu::ChannelName found = fmu::structured_name(channel);
    EXPECT_EQ(found.name, name);
    EXPECT_EQ(found.unit, unit);
    EXPECT_EQ(found.of_wheel, of_wheel);
  };
  expect("fz_fl_n", "wheel.*.fz", "N", true);
  expect("brake_rr_command_pa", "wheel.*.brake_command", "Pa", true);
  expect("wheel_rl_radps", "wheel.*.spin", "rad/s", true);
  expect("tyre_fr_k", "wheel.*.tyre_temperature", "K", true);
  expect("on_road_*", "wheel.*.on_road", "1", true);
  expect("roll_rate_radps", "car.roll_rate", "rad/s", false);
  expect("boost", "car.boost", "1", false);
  expect("u_m", "car.u", "m", false);
  EXPECT_EQ(fmu::structured_name("brake_fl_pa").pattern, "brake_*_pa");
}

}  // namespace channel_name_test
