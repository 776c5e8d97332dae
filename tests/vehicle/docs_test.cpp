// The commands of the documents about the car run, one after the other in one folder.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "support/demo_circuit.h"
#include "support/places.h"
#include "support/run_crgbuild.h"

namespace docs_test {

using ::testing::HasSubstr;

/// The ```sh blocks of a document.
std::string commands_of(const std::string& document) {
  const std::string text = cli::read(fmt::format("{}/docs/{}", places::source(), document));
  std::string script = "set -euo pipefail\n";
  for (std::size_t at = 0; (at = text.find("```sh\n", at)) != std::string::npos;) {
    const std::size_t end = text.find("\n```", at);
    script += text.substr(at + 6, end - at - 5);
    at = end;
  }
  return script;
}

class CarDocs : public ::testing::Test {
 protected:
  void SetUp() override {
    support::put_demo_circuit(folder.path());
    std::filesystem::create_symlink(places::source() + "/vehicles", folder / "vehicles");
  }
  void run(const std::string& document) {
    namespace fs = std::filesystem;
    cli::write(folder / "all.sh", commands_of(document));
    const std::string command =
        fmt::format("cd '{}' && PATH='{}':'{}':'{}':'{}':\"$PATH\" bash all.sh > log 2>&1",
                    folder.path(), fs::path(places::crgbuild()).parent_path().string(),
                    fs::path(places::crgdrive()).parent_path().string(),
                    fs::path(places::crgidentify()).parent_path().string(),
                    fs::path(places::crgsim()).parent_path().string());
    ASSERT_EQ(std::system(command.c_str()), 0) << cli::read(folder / "log");
  }
  cli::Folder folder;
};

TEST_F(CarDocs, EveryCommandOfTheTourRuns) {
  run("crgdrive.md");
  const std::string page = cli::read(folder / "front.html");
  EXPECT_THAT(page, HasSubstr("Aligning moment"));
  EXPECT_THAT(page, HasSubstr("5600 N"));
  EXPECT_THAT(cli::read(folder / "lap.html"), HasSubstr("Load rear right"));
  EXPECT_THAT(cli::read(folder / "mine.csv"), HasSubstr("# crgdrive lap: vehicle my_car"));
  EXPECT_THAT(cli::read(folder / "laps.html"), HasSubstr("Load rear right"));
  EXPECT_THAT(cli::read(folder / "steering.txt"), HasSubstr("steering.dead_time_s = 0.02"));
}

TEST_F(CarDocs, AForeignLogIsReplayed) {
  run("recordings.md");
  EXPECT_THAT(cli::read(folder / "log"), HasSubstr("yaw_rate_radps"));
  EXPECT_TRUE(cli::exists(folder / "out/errors.csv"));
}

TEST_F(CarDocs, TheCarBecomesAnFmu) {
  run("fmu.md");
  EXPECT_THAT(cli::read(folder / "log"), HasSubstr("car3.fmu: FMI 3.0 co-simulation"));
}

TEST_F(CarDocs, AUnitIsRun) {
  run("crgsim.md");
  EXPECT_THAT(cli::read(folder / "log"), HasSubstr("rows of 3 columns, to 2 s"));
  EXPECT_THAT(cli::read(folder / "braking.csv"), HasSubstr("time_s,car.vx,wheel.fl.fz\n0,"));
}

TEST_F(CarDocs, SensorsMeasureAManoeuvre) {
  run("sensors.md");
  EXPECT_THAT(cli::read(folder / "sine.csv"), HasSubstr("devices.yaml"));
}

}  // namespace docs_test
