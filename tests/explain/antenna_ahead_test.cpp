// Where a receiver sees the car from: an antenna ahead of the centre of mass is named as that.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "proof.h"
#include "recording/table.h"

namespace explain_test {
namespace antenna_ahead_test {

TEST(SlowAntennaAhead, IsNoZeroOfTheHeading) {
  constexpr double kAhead_m = 1.5;
  Proof drawn("none");
  recording::Table log = recording::read_table(drawn.path("run.csv"));
  const auto column = [&](const char* name) -> std::vector<double>& {
    return log.columns[static_cast<std::size_t>(
        std::find(log.names.begin(), log.names.end(), name) - log.names.begin())];
  };
  const std::vector<double>& heading = column("yaw_rad");
  for (std::size_t i = 0; i < log.rows(); ++i) {
    column("x_m")[i] += kAhead_m * std::cos(heading[i]);
    column("y_m")[i] += kAhead_m * std::sin(heading[i]);
  }
  drawn.folder.file("none/ahead.csv", recording::format_table(log));
  const json found = drawn.explain("ahead.csv");
  EXPECT_EQ(found.at("verdict"), "explained");
  ASSERT_EQ(found.at("findings").size(), 1u) << base::dump_json(found.at("findings"), 1);
  const json& f = found.at("findings").at(0);
  EXPECT_EQ(f.at("mechanism"), "sensor.lever_arm");
  EXPECT_EQ(f.at("channel"), "x_m,y_m");
  EXPECT_NEAR(f.at("parameters").at(0).at("value").get<double>(), kAhead_m, 0.15);
}

}  // namespace antenna_ahead_test
}  // namespace explain_test
