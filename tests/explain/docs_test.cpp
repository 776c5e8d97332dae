// The commands of the document about crgexplain, one after the other in one folder.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "support/places.h"
#include "support/run_crgbuild.h"

namespace docs_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// The ```sh blocks of the document; `build` in place of build/dev, where its reader has it.
std::string commands(const std::string& build) {
  std::string text = cli::read(fmt::format("{}/docs/crgexplain.md", places::source()));
  std::string script = "set -euo pipefail\n";
  for (std::size_t at = 0; (at = text.find("```sh\n", at)) != std::string::npos;) {
    const std::size_t end = text.find("\n```", at);
    script += text.substr(at + 6, end - at - 5);
    at = end;
  }
  for (std::size_t at = 0; (at = script.find("build/dev", at)) != std::string::npos;
       at += build.size())
    script.replace(at, 9, build);
  // Two laps in place of five show the same, and one blind trial in place of two.
  for (const auto& [stated, small] :
       {std::pair<std::string, std::string>{"--scenario banking demo", "--scenario banking demo 2"},
        {"--count 2", "--count 1"}})
    script.replace(script.find(stated), stated.size(), small);
  if (std::getenv("KERBSTONE_HEAVY") == nullptr)
    script.resize(script.find(build + "/tests/blind_trials"));
  return script;
}

TEST(ExplainDocs, EveryCommandOfTheTourRuns) {
  namespace fs = std::filesystem;
  const cli::Folder folder;
  cli::write(folder / "all.sh",
             commands(fs::path(places::make_trials()).parent_path().parent_path().string()));
  const std::string command =
      fmt::format("cd '{}' && PATH='{}':\"$PATH\" bash all.sh > log 2>&1", folder.path(),
                  fs::path(places::crgexplain()).parent_path().string());
  ASSERT_EQ(std::system(command.c_str()), 0) << cli::read(folder / "log");
  const std::string log = cli::read(folder / "log");
  const std::size_t first = log.find("verdict: "), second = log.find("verdict: ", first + 1);
  ASSERT_NE(second, std::string::npos) << log;
  EXPECT_THAT(log.substr(first, second - first),
              AllOf(StartsWith("verdict: explained"), HasSubstr("road.banking")));
  EXPECT_THAT(log.substr(second), StartsWith("verdict: none"));
  if (std::getenv("KERBSTONE_HEAVY") != nullptr) {
    EXPECT_THAT(log.substr(second), HasSubstr("false alarm"));  // of the scored trials
  }
  const std::string page = cli::read(folder / "found/report.html");
  EXPECT_THAT(page, AllOf(HasSubstr("road.banking"), HasSubstr("class='line s1'"),
                          HasSubstr("one relation")));
}

}  // namespace docs_test
