// What a circuit car's own bus shows of it: a log of another maker and of no car of ours.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "base/json_text.h"
#include "support/places.h"
#include "support/run_tool.h"
#include "support/temporary_folder.h"

namespace real_log_test {

using nlohmann::json;
using ::testing::HasSubstr;

/// Sample1.ld of MoTeC, with the mapping that `crgexplain map` proposes.
struct RealLog {
  std::string path = places::data() + "/recordings/Sample1.ld";
  support::TemporaryFolder folder;
  std::string mapping = folder.path("mapping.yaml");

  bool is_here() const { return std::filesystem::exists(path); }

  void map() {
    ASSERT_EQ(support::run_tool(places::crgexplain(), {"map", path, "-q", "-o", mapping}).code, 0);
  }

  support::ToolRun run(const std::string& command, bool as_json = true) const {
    std::vector<std::string> words{
        command,     path,   "--car", places::source() + "/vehicles/open_wheel/vehicle.yaml",
        "--mapping", mapping};
    if (as_json) words.emplace_back("--json");
    return support::run_tool(places::crgidentify(), words);
  }
};

TEST(RealLog, ShowsAnEngineAndBrakesAndSaysWhatItCannot) {
  RealLog log;
  if (!log.is_here()) GTEST_SKIP() << "no Sample1.ld here";
  log.map();
  const support::ToolRun engine = log.run("engine");
  ASSERT_EQ(engine.code, 0) << engine.err;
  int seen = 0, places = 0;
  const json said = base::parse_json<json>(engine.out);
  for (const json& place : said.at("map").at("places")) {
    seen += place.contains("torque_nm") ? 1 : 0;
    ++places;
  }
  // 15 of 78 on 2026-11-26.
  EXPECT_GE(seen, 8);
  EXPECT_LE(seen, places / 2);
  // Nobody weighed this car and knows its brakes; that they differ from ours must be seen.
  const support::ToolRun brakes = log.run("brakes", false);
  ASSERT_EQ(brakes.code, 0) << brakes.err;
  EXPECT_THAT(brakes.out, HasSubstr("front.brake_area_m2 = "));
  EXPECT_THAT(brakes.out, HasSubstr("front and rear pressures go together"));
  EXPECT_THAT(brakes.out, HasSubstr("windows at 0 places with temperatures of all discs"));
  for (const char* const command : {"suspension", "mass"}) {
    const support::ToolRun refused = log.run(command, false);
    EXPECT_EQ(refused.code, 1) << command;
    EXPECT_THAT(refused.err, HasSubstr("loads")) << command;
  }
}

}  // namespace real_log_test
