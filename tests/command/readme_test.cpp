// The README's commands run one after the other, as somebody types them who has only read it.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "support/demo_circuit.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "support/run_tool.h"

namespace readme_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// Of all that stands in backticks: commands that write or show something. Those for tracks of
/// torcs-data stand in a block of their own.
std::vector<std::string> commands_of(const std::string& text) {
  const std::regex command(
      "`((crgbuild|lidar2mesh|crgdrive|crgexplain|crgidentify|crgsim) [^`]* -o [^`]+|"
      "kerbstone (open|view) [^`]+)`");
  std::vector<std::string> found;
  for (std::sregex_iterator i(text.begin(), text.end(), command), end; i != end; ++i)
    found.push_back((*i)[1]);
  return found;
}

/// What makes a command of minutes one of a second, and shows no page. KERBSTONE_HEAVY=1: all of
/// it.
std::string shortened(std::string command) {
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  if (command.starts_with("kerbstone view ")) command += " --no-open --stop-s 0.2";
  if (heavy) return command;
  if (command.starts_with("crgbuild ")) command += " --u-step-m 0.25 --v-step-m 0.25";
  if (command.starts_with("crgexplain run ")) command += " --skip-simulation --nulls 100";
  if (command.starts_with("crgidentify forces "))
    command =
        std::regex_replace(command, std::regex(" log.csv "), " begin.csv ") + " --noise-rounds 0";
  return command;
}

TEST(ReadmeDocs, EveryCommandRuns) {
  const cli::Folder folder;
  support::put_demo_circuit(folder.path());
  fs::create_symlink(places::source() + "/vehicles", folder / "vehicles");
  std::string path;
  for (const support::Tool& tool : support::all_tools())
    path += fs::path(tool.path).parent_path().string() + ":";
  const auto run = [&](const std::string& command) {
    return std::system(fmt::format("cd '{}' && PATH='{}'\"$PATH\" && {{ {}; }} > log 2>&1",
                                   folder.path(), path, command)
                           .c_str());
  };
  // What the reader has: a mesh, scans of a stretch of it, a unit and what it shall do.
  ASSERT_EQ(run("crgbuild synth tracks/kerbstone-ring/circuit.yaml -o . && "
                "cp kerbstone-ring.obj my_track.obj && "
                "lidar2mesh synth tracks/kerbstone-ring/circuit.yaml -o scans --u-begin-m 380 "
                "--u-end-m 410 --laps 1 --cars 0 --azimuths 128 && "
                "crgdrive fmu vehicles/open_wheel/vehicle.yaml -o car.fmu && "
                "printf 'time_s,input.throttle\\n0,0\\n1,1\\n' > controls.csv"),
            0)
      << cli::read(folder / "log");
  const std::vector<std::string> commands = commands_of(cli::read(places::source() + "/README.md"));
  ASSERT_GE(commands.size(), 9u);
  for (const std::string& command : commands) {
    // The beginning of a log, for what takes as long as the log is.
    ASSERT_EQ(run("[ ! -e log.csv ] || head -n 250 log.csv > begin.csv"), 0);
    EXPECT_EQ(run(shortened(command)), 0) << command << "\n" << cli::read(folder / "log");
  }
  EXPECT_THAT(cli::read(folder / "mapping.yaml"), HasSubstr("time_s"));
  for (const char* file :
       {"out/my_track/report.html", "out/refined/refined.crg", "out/found/report.html", "run.csv"})
    EXPECT_TRUE(fs::exists(folder / file)) << file;
}

}  // namespace readme_test
