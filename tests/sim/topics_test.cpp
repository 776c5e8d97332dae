#include "topics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "base/error.h"

namespace topics_test {

using namespace sim;  // NOLINT: a test of this library
using ::testing::ElementsAre;
using ::testing::HasSubstr;

UnitDescription unit_with(const std::vector<std::string>& names) {
  UnitDescription out;
  for (const std::string& name : names) {
    UnitVariable variable;
    variable.name = name;
    out.variables.push_back(variable);
  }
  return out;
}

ServeOptions options_with(std::vector<vehicle::SignalTopic> topics) {
  ServeOptions out;
  vehicle::SignalSensor x, y;
  x.name = "gnss.x", y.name = "gnss.y";
  out.devices = {1, {x, y}, {}, {{"gnss", 0, 1}}, std::move(topics)};
  return out;
}

TEST(Topics, WhatAMessageNeedsIsMeasured) {
  ServeOptions options = options_with(
      {{"fix",
        "sensor_msgs/NavSatFix",
        "gnss",
        "",
        {{"latitude", "gnss.latitude_deg"}, {"altitude", "120.5"}, {"longitude", "car.x"}}}});
  options.measurements = {"car.x"};
  const TopicPlan plan = plan_topics(options, unit_with({"car.x"}), "u.fmu");
  EXPECT_THAT(options.measurements, ElementsAre("car.x", "gnss.latitude_deg", "gnss.x.age_s"));
  ASSERT_EQ(plan.topics.size(), 1u);
  MeasurementMessage message;
  message.time_s = 2.0;
  message.values = {7.0, 48.1, 0.05};
  const Told told(plan.topics[0], message);
  EXPECT_EQ(told.value("latitude"), 48.1);
  EXPECT_EQ(told.value("altitude"), 120.5);
  EXPECT_EQ(told.value("longitude"), 7.0);
  EXPECT_EQ(told.value("position.variance"), 0.0);
  EXPECT_FALSE(told.has("position.variance"));
  EXPECT_DOUBLE_EQ(told.time_s(), 1.95) << "when the sample was true";
}

TEST(Topics, ACarWithoutAFileTellsWhereItIsAndHowItTurns) {
  ServeOptions options;
  const TopicPlan plan =
      plan_topics(options, unit_with({"car.x", "car.yaw_rate", "input.steering"}), "u.fmu");
  ASSERT_EQ(plan.topics.size(), 2u);
  EXPECT_EQ(plan.topics[0].type, "nav_msgs/Odometry");
  EXPECT_THAT(plan.topics[0].fields, ElementsAre("position.x", "angular.z"));
  EXPECT_THAT(plan.topics[1].fields, ElementsAre("angular_velocity.z"));
  EXPECT_THAT(options.measurements, ElementsAre("car.x", "car.yaw_rate"));
  EXPECT_THAT(options.commands, ElementsAre("input.steering"));
}

TEST(Topics, ACommandActsOnWhatTheUnitHasOrTheFileSays) {
  ServeOptions options;
  options.commands = {"wind"};
  options.devices.commands = {{"throttle", "pedal", 0.5}};
  UnitDescription unit = unit_with({"input.steering", "input.brake", "wind"});
  unit.variables[1].size = 4;
  const TopicPlan plan = plan_topics(options, unit, "u.fmu");
  EXPECT_THAT(options.commands, ElementsAre("wind", "input.steering", "throttle", "input.brake[1]",
                                            "input.brake[2]", "input.brake[3]", "input.brake[4]"));
  CarCommand said;
  said.sequence = 9;
  said.fields = {0.1, 0.2, 1, 2, 3, 4, std::numeric_limits<double>::quiet_NaN(), 0};
  said.others = {{"wind", 5.0}};
  std::string why;
  const auto command = command_of(said, plan, why);
  ASSERT_TRUE(command) << why;
  EXPECT_EQ(command->sequence, 9u);
  EXPECT_THAT(command->values, ElementsAre(5.0, 0.1, 0.2, 1, 2, 3, 4)) << "no gear to be set";
  said.fields[1] = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(command_of(said, plan, why));
  EXPECT_EQ(why, "a value that is not finite");
  said.resets = true;  // then the fields do not act
  said.starts = {{"start.speed", 20.0}};
  why.clear();
  const auto reset = command_of(said, plan, why);
  ASSERT_TRUE(reset) << why;
  EXPECT_TRUE(std::isnan(reset->values[1]));
  EXPECT_EQ(reset->starts.size(), 1u);
  said.starts.clear();
  said.state = "corner";
  EXPECT_EQ(command_of(said, plan, why)->state, "corner");
  said.save = "corner";
  EXPECT_FALSE(command_of(said, plan, why));
  EXPECT_EQ(why, "a state to save and a reset at once");
  said.resets = false;
  said.state = "";
  why.clear();
  said.fields[1] = 0.0;
  EXPECT_EQ(command_of(said, plan, why)->save, "corner");
  said.others = {{"rain", 1.0}};
  EXPECT_FALSE(command_of(said, plan, why));
  EXPECT_EQ(why, "'rain' is no command of this run");
}

TEST(Topics, RefusesInOneLine) {
  const auto refusal = [](const vehicle::SignalTopic& topic) -> std::string {
    ServeOptions options = options_with({topic});
    options.devices.road.scans.resize(1);
    options.devices.road.scans[0].name = "lidar";
    try {
      plan_topics(options, unit_with({"car.x"}), "u.fmu");
    } catch (const base::Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal({"a/b_1", "kerbstone_msgs/Values", "", "", {{"any", "car.x"}}}), "");
  EXPECT_THAT(refusal({"clock", "kerbstone_msgs/Values", "", "", {}}),
              HasSubstr("two topics would be called clock"));
  EXPECT_THAT(refusal({"lidar", "kerbstone_msgs/Values", "", "", {}}),
              HasSubstr("two topics would be called lidar"));
  EXPECT_THAT(refusal({"a b", "kerbstone_msgs/Values", "", "", {}}),
              HasSubstr("u.fmu: the topic a b has a name that ROS 2 does not take"));
  EXPECT_THAT(refusal({"a/", "kerbstone_msgs/Values", "", "", {}}), HasSubstr("a name that"));
  EXPECT_THAT(refusal({"/a", "kerbstone_msgs/Values", "", "", {}}), HasSubstr("a name that"));
  EXPECT_THAT(refusal({"a", "sensor_msgs/Image", "", "", {}}),
              HasSubstr("has the type sensor_msgs/Image; known are sensor_msgs/Imu, "));
  EXPECT_THAT(refusal({"a", "sensor_msgs/Imu", "", "", {{"speed", "car.x"}}}),
              HasSubstr("tells speed, which is no field of sensor_msgs/Imu; it has roll, "));
}

TEST(Topics, TurnsAreByYawThenPitchThenRoll) {
  // The matrix of the quaternion is that of the three turns, one after another.
  const double roll_rad = 0.3, pitch_rad = -0.2, yaw_rad = 2.5;
  const auto [x, y, z, w] = quaternion(roll_rad, pitch_rad, yaw_rad);
  EXPECT_NEAR(x * x + y * y + z * z + w * w, 1.0, 1e-15);
  // Forward and left of the body on the map: columns of Rz(yaw) Ry(pitch) Rx(roll).
  EXPECT_NEAR(1 - 2 * (y * y + z * z), std::cos(yaw_rad) * std::cos(pitch_rad), 1e-15);
  EXPECT_NEAR(2 * (x * y + z * w), std::sin(yaw_rad) * std::cos(pitch_rad), 1e-15);
  EXPECT_NEAR(2 * (x * z - y * w), -std::sin(pitch_rad), 1e-15);
  EXPECT_NEAR(2 * (y * z + x * w), std::cos(pitch_rad) * std::sin(roll_rad), 1e-15);
  const auto left = quaternion(0.0, 0.0, 0.5 * std::numbers::pi);
  EXPECT_THAT(left, ElementsAre(0, 0, testing::DoubleNear(std::sqrt(0.5), 1e-15),
                                testing::DoubleNear(std::sqrt(0.5), 1e-15)));
}

}  // namespace topics_test
