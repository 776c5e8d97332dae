#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "support/places.h"
#include "support/run_crgbuild.h"
#include "support/run_tool.h"

namespace measure_workers_test {

namespace fs = std::filesystem;

support::ToolRun shell(const std::string& command) {
  return support::run_tool("/bin/bash", {"-c", command});
}

/// Workers, seconds by the clock, of processor, of that of jobs, and of that done alone, of each
/// run.
std::vector<std::vector<double>> runs_in(const std::string& printed) {
  const std::regex line(R"(([12]) workers: +([0-9.]+) s by the clock, +([0-9.]+) s of processor, )"
                        R"(of which jobs +([0-9.]+), alone ([0-9.]+);)");
  std::vector<std::vector<double>> out;
  for (auto it = std::sregex_iterator(printed.begin(), printed.end(), line);
       it != std::sregex_iterator(); ++it) {
    out.emplace_back();
    for (int group = 1; group <= 5; ++group) out.back().push_back(std::stod((*it)[group]));
  }
  return out;
}

// Two meshes alike, a round: what is printed goes together, and the clock is that of this test.
TEST(MeasureWorkers, ItsFiguresGoTogether) {
  if (shell("command -v snakemake").code != 0)
    GTEST_SKIP() << "snakemake is not installed (scripts/setup campaign)";
  const cli::Folder folder;
  cli::write(folder / "one.obj", cli::Stadium{}.obj());
  cli::write(folder / "two.obj", cli::Stadium{}.obj());
  const std::string tools = fs::path(places::crgbuild()).parent_path().parent_path();
  const auto begin = std::chrono::steady_clock::now();
  const support::ToolRun ran =
      shell(fmt::format("python3 '{0}/campaigns/measure_workers.py' '{1}/out' --tools '{2}' "
                        "--rounds 1 '{1}/one.obj' '{1}/two.obj'",
                        places::source(), folder.path(), tools));
  const double all_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto runs = runs_in(ran.out);
  ASSERT_EQ(runs.size(), 2u) << ran.out;
  EXPECT_EQ(runs[0][0], 1);
  EXPECT_EQ(runs[1][0], 2);
  EXPECT_LT(runs[0][1] + runs[1][1], all_s + 0.02);
  EXPECT_GT(runs[0][1] + runs[1][1], 0.5 * all_s);
  for (const auto& run : runs) {
    EXPECT_GT(run[3], 0.0);
    EXPECT_LT(run[3], run[2]);  // the engine computes, too
    EXPECT_GT(run[4], 0.0);
    EXPECT_LE(run[4], run[2] - run[3] + 0.02);
  }
  std::smatch limit;
  ASSERT_TRUE(std::regex_search(ran.out, limit, std::regex("limit on idle cores: ([0-9.]+)")))
      << ran.out;
  // Two jobs on two workers take no less than half of both together, their starts included.
  EXPECT_LE(std::stod(limit[1]), runs[0][2] / (0.5 * (runs[1][2] + runs[1][4])) + 0.02) << ran.out;
  EXPECT_GE(std::stod(limit[1]), runs[0][2] / runs[1][2] - 0.02) << ran.out;
  EXPECT_THAT(ran.out, ::testing::HasSubstr("2 jobs; the clock, one worker / two: "));
}

}  // namespace measure_workers_test
