// The commands of the document about crgexplain, one after the other in one folder.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <regex>

#include "support/demo_circuit.h"
#include "support/places.h"
#include "support/run_crgbuild.h"

namespace docs_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

/// The ```sh blocks of the document.
std::string commands() {
  const std::string text = cli::read(places::source() + "/docs/crgexplain.md");
  std::string script = "set -euo pipefail\n";
  for (std::size_t at = 0; (at = text.find("```sh\n", at)) != std::string::npos;) {
    const std::size_t end = text.find("\n```", at);
    script += text.substr(at + 6, end - at - 5);
    at = end;
  }
  return script;
}

TEST(SlowExplainDocs, EveryCommandOfTheTourRuns) {
  namespace fs = std::filesystem;
  const cli::Folder folder;
  support::put_demo_circuit(folder.path());
  fs::create_symlink(places::source() + "/vehicles", folder / "vehicles");
  // Its reader has the programs that are installed, and none of the tests.
  EXPECT_THAT(commands(), Not(HasSubstr("build/")));
  cli::write(folder / "all.sh", commands());
  std::string path;
  for (const std::string& tool : {places::crgbuild(), places::crgdrive(), places::crgexplain()})
    path += fs::path(tool).parent_path().string() + ":";
  const std::string command =
      fmt::format("cd '{}' && PATH='{}'\"$PATH\" bash all.sh > log 2>&1", folder.path(), path);
  ASSERT_EQ(std::system(command.c_str()), 0) << cli::read(folder / "log");
  const std::string log = cli::read(folder / "log");
  const std::size_t first = log.find("verdict: "), second = log.find("verdict: ", first + 1);
  ASSERT_NE(second, std::string::npos) << log;
  const std::string found = log.substr(first, second - first);
  EXPECT_THAT(found, HasSubstr("parameter.drag"));
  if (std::getenv("KERBSTONE_HEAVY") != nullptr) {  // the few bends of a third leave a tie besides
    EXPECT_THAT(found, StartsWith("verdict: explained"));
  }
  std::smatch drag;
  ASSERT_TRUE(std::regex_search(
      found, drag, std::regex("aero.drag_area_m2 = [0-9.]+ m2 \\[([0-9.]+), ([0-9.]+)\\]")));
  EXPECT_LT(std::stod(drag[1]), 1.14);
  EXPECT_GT(std::stod(drag[2]), 1.14);
  EXPECT_THAT(log.substr(second), StartsWith("verdict: none"));
  EXPECT_THAT(cli::read(folder / "found/report.html"),
              AllOf(HasSubstr("parameter.drag"), HasSubstr("class='line s1'")));
}

}  // namespace docs_test
