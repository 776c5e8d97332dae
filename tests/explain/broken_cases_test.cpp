// Recordings of another simulator (TUMFTM Open-Car-Dynamics) with one column broken each: what was
// done to them is in the README beside them.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "crg/file.h"
#include "explain/signals.h"
#include "recording/table.h"
#include "support/figure.h"
#include "support/places.h"
#include "support/run_tool.h"
#include "support/temporary_folder.h"
#include "vehicle/error.h"

namespace explain {
namespace broken_cases_test {

using ::testing::HasSubstr;

class BrokenCases : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(cases()))
      GTEST_SKIP() << "skipped: " << cases() << " is not there";
    const std::string edges = places::data() + "/edges/circuit_a";
    const support::ToolRun built = support::run_tool(
        places::crgbuild(),
        {"from-edges", edges + "_left.csv", edges + "_right.csv", "-o", folder_.path("road")});
    ASSERT_EQ(built.code, 0) << built.err;
  }
  static std::string cases() { return places::data() + "/cases/explain"; }
  std::string log_of(const std::string& name) const {
    const std::string log = folder_.path(name + ".csv");
    EXPECT_EQ(
        std::system(fmt::format("xz -dc '{}/{}/run.csv.xz' > '{}'", cases(), name, log).c_str()),
        0);
    return log;
  }
  std::string track() const { return folder_.path("road/circuit_a.crg"); }

  support::TemporaryFolder folder_;
};

TEST_F(BrokenCases, EachIsNamedAsWhatItIs) {
  const crg::Surface road(crg::read(track()));
  const std::map<std::string, std::string> said{
      {"accel_g", "'ay_mps2' looks like multiples of g"},
      {"ay_half_after_100s", "until about 50 s, and 0.5"},  // of a log of 95 s
      {"wheel_stuck", "'wheel_fl_radps' differs from 'wheel_fr_radps'"},
      {"wheels_lr", "'wheel_fl_radps' is faster in left turns"},
      {"fz_lr", "'fz_fl_n' is loaded in left turns"},
      {"gps_late_02", "come 0.2"},
      {"imu_late_02", "'ax_mps2', 'ay_mps2', 'yaw_rate_radps' come 0.2"},
      {"gyro_drift", "'yaw_rate_radps' has a zero that drifts"},
      {"yawrate_deg", "'yaw_rate_radps' looks like degrees"},
      {"steer_sign", "'steer_rad' has the other sign"},
      {"throttle_inverted", "'throttle' is largest where the car slows down"},
      {"ned_sensors", "'ay_mps2' has the other sign"},
      {"vx_held_5hz_1kmh", "'vx_mps' has 4.9 measurements a second"},
      {"gps_frozen", "'x_m', 'y_m' stand still 4 times"},
      {"standstill", ""}};
  int green = 0;  // without a word
  for (const auto& [name, words] : said) {
    std::string remarks;
    try {
      const recording::Table log = recording::read_table(log_of(name));
      const Signals s = make_signals(log, identity_mapping(log), road, name);
      for (const std::string& remark : s.remarks) remarks += remark + "\n";
      const bool goes_on =
          name == "standstill" || name.starts_with("gps_") || name == "imu_late_02";
      EXPECT_EQ(s.broken, !goes_on) << name;
    } catch (const vehicle::Error& error) {
      remarks = error.what();
    }
    green += remarks.find(words) == std::string::npos ? 1 : 0;
    EXPECT_THAT(remarks, HasSubstr(words)) << name;
    if (words.empty()) {
      EXPECT_THAT(remarks, ::testing::Not(HasSubstr("not used"))) << name;
    }
  }
  support::figure("logs", static_cast<double>(said.size())), support::figure("unnamed", green);
}

}  // namespace broken_cases_test
}  // namespace explain
