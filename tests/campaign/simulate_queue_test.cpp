#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "support/places.h"
#include "support/run_crgbuild.h"
#include "support/run_tool.h"

namespace simulate_queue_test {

using ::testing::ContainsRegex;

/// Four jobs of an hour and one of half an hour that needs the first; what the last writes takes
/// the disk half an hour more.
TEST(SimulateQueue, HoursThatCanBeCountedByHand) {
  if (support::run_tool("/bin/sh", {"-c", "command -v python3"}).code != 0)
    GTEST_SKIP() << "python3 is not installed";
  const cli::Folder folder;
  std::filesystem::create_directories(folder / "state/a");
  std::string jobs;
  for (int i = 0; i < 5; ++i) {
    jobs += fmt::format(R"({}{{"id": "a/{}", "after": [{}]}})", i == 0 ? "" : ",", i,
                        i == 4 ? "\"a/0\"" : "");
    cli::write(
        folder / fmt::format("state/a/{}.cost.json", i),
        i == 4 ? R"({"cpu_s": 1800, "output_mb": 1800})" : R"({"cpu_s": 3600, "output_mb": 0})");
  }
  cli::write(folder / "plan.json", "{\"jobs\": [" + jobs + "]}");
  const support::ToolRun ran = support::run_tool(
      "/bin/sh", {"-c", fmt::format("python3 '{}/campaigns/simulate_queue.py' '{}' "
                                    "--submit-per-s 1000 --disk-mb-per-s 1",
                                    places::source(), folder.path())});
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, ContainsRegex("5 jobs, 4.50 CPU hours, 1.8 GB"));
  EXPECT_THAT(ran.out, ContainsRegex("\n      1     5.000 "));  // 4 h, 30 min, 30 min on the disk
  EXPECT_THAT(ran.out, ContainsRegex("\n      2     3.000 "));  // the last begins after 2 h
  EXPECT_THAT(ran.out, ContainsRegex("\n     10     2.000 "));  // an hour before the last
}

}  // namespace simulate_queue_test
