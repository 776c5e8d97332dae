// Topics against the middleware that ROS 2 has by default, which shares no code with ours.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <sstream>

#include "sim/dds.h"
#include "some_unit.h"
#include "support/own_domain.h"
#include "support/places.h"

namespace fastdds_test {

#ifdef FASTDDS_PEER
using sim_tests::description_2, sim_tests::scalar_2, sim_tests::write_unit;
using ::testing::HasSubstr;

const char* const kDevices = R"(commands:
  steering_angle: {signal: a, gain: 2}
topics:
  imu: {type: sensor_msgs/Imu, frame: box, fields: {angular_velocity.z: b, linear_acceleration.x: m, linear_acceleration.z: 9.81, angular_velocity.variance: 0.5}}
  fix: {type: sensor_msgs/NavSatFix, frame: antenna, fields: {latitude: 48.5, longitude: b, position.variance: 4}}
  car/odom: {type: nav_msgs/Odometry, fields: {position.x: b, position.y: m, yaw: b, linear.x: 12}}
  twist: {type: geometry_msgs/TwistWithCovarianceStamped, frame: base_link, fields: {linear.x: b, angular.z: 7}}
)";

TEST(FastDds, ANodeOfAnotherMiddlewareDrivesAndHears) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(
      folder,
      description_2("through", scalar_2("a", 10, "input") + scalar_2("n", 11, "input", "Integer") +
                                   scalar_2("b", 20, "output") +
                                   scalar_2("m", 21, "output", "Integer")),
      2);
  folder.file("devices.yaml", kDevices);
  folder.file("all.sh", fmt::format(R"(cd '{0}'
{1} serve '{2}' --dds --domain {3} --step-s 0.01 --lockstep --every 5 --devices devices.yaml --command n \
  --json > told.json 2> errors.txt & serve=$!
{4} {3} 3 > heard.txt; heard=$?
wait $serve && exit $heard)",
                                    folder.path("."), places::crgsim(), unit, places::own_domain(),
                                    FASTDDS_PEER));
  ASSERT_EQ(std::system(("timeout 120 bash " + folder.path("all.sh")).c_str()), 0)
      << folder.read("heard.txt") << folder.read("errors.txt");
  std::string wanted;
  for (int k = 1; k <= 3; ++k) {
    const double time_s = 0.05 * k, b = 2.0 * 0.25 * k;  // gain and command
    wanted += fmt::format(
        "step {0} {1:g} clock {1:g} imu {1:g} box {2:g} 0.5 0 9.81 fix {1:g} antenna 48.5 {2:g} 4 "
        "odom {2:g} 0 {3:g} 12 twist base_link {2:g} 7\n",
        k, time_s, b, std::sin(0.5 * b));
  }
  EXPECT_EQ(folder.read("heard.txt"), wanted);
  EXPECT_THAT(folder.read("told.json"), HasSubstr("by a command"));
}
#else
TEST(FastDds, IsInstalled) {
  GTEST_SKIP() << "without libfastrtps-dev, or without Cyclone DDS, nobody else is asked";
}
#endif

}  // namespace fastdds_test
