#include "wish.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "support/temporary_folder.h"

namespace wish_test {

using nlohmann::ordered_json;
using ::testing::ElementsAre;

class Wish : public ::testing::Test {
 protected:
  Wish() {
    std::filesystem::create_directories(folder_.path("a/tracks/oval"));
    std::filesystem::create_directories(folder_.path("b"));
    folder_.file("a/tracks/oval/track.yaml", "mesh: oval.obj\n");
    folder_.file("a/ring.crg", "");
    folder_.file("b/-o.crg", "");
    folder_.file("secret.crg", "");
  }
  view::Wish of(const char* json) {
    return view::wish_of(base::parse_json<ordered_json>(json, false),
                         view::Folders({folder_.path("a"), folder_.path("b")}));
  }
  int status(const char* json) {
    try {
      of(json);
    } catch (const view::Refusal& refusal) {
      return refusal.status;
    }
    return 200;
  }
  support::TemporaryFolder folder_;
};

TEST_F(Wish, IsTheCommandThatSomebodyWouldType) {
  const view::Wish build = of(R"({"do": "build", "input": "0/tracks/oval/track.yaml"})");
  EXPECT_THAT(build.command,
              ElementsAre("crgbuild", "build", "tracks/oval/track.yaml", "-o", "out/oval"));
  EXPECT_EQ(build.result, "out/oval");
  EXPECT_EQ(view::result_of("meshes/ring.obj"), "out/ring");
  EXPECT_THAT(of(R"({"do": "preview", "input": "0/ring.crg", "raw": true})").command,
              ElementsAre("crgbuild", "preview", "ring.crg", "-o", "-", "--raw"));
}

TEST_F(Wish, FilesOfOtherFoldersAreNamedWholeSoThatNoneIsAFlag) {
  const view::Wish report =
      of(R"({"do": "report", "road": "0/ring.crg", "against": "1/-o.crg", "mesh": ""})");
  EXPECT_THAT(report.command,
              ElementsAre("crgbuild", "report", "ring.crg", "-o", "out/ring-report", "--against",
                          std::filesystem::canonical(folder_.path("b/-o.crg")).string()));
}

TEST_F(Wish, ALapOfTheBuiltInDriverLiesBesideThePersons) {
  std::filesystem::create_directories(folder_.path("a/found"));
  folder_.file("a/found/vehicle.yaml", "");
  folder_.file("a/found/friction.crg", "");
  const view::Wish lap = of(
      R"({"do": "lap", "vehicle": "0/found/vehicle.yaml", "road": "0/ring.crg", "friction": "0/found/friction.crg"})");
  EXPECT_THAT(lap.command,
              ElementsAre("crgdrive", "lap", "--car", "found/vehicle.yaml", "--road", "ring.crg",
                          "--grip", "found/friction.crg", "-o", "out/drives/found-lap-1.csv"));
  EXPECT_EQ(lap.result, "out/drives/found-lap-1.csv");
  EXPECT_EQ(status(R"({"do": "lap", "vehicle": "0/../secret.crg", "road": "0/ring.crg"})"), 404);
}

TEST_F(Wish, ParametersOfADriveAreCommandedAndMeasured) {
  folder_.file("a/car.fmu", "");
  const auto drive = [&](const std::string& list) {
    return of((R"({"do": "drive", "unit": "0/car.fmu", "parameters": )" + list + "}").c_str());
  };
  const auto command = drive(R"(["parameter.chassis.mass_kg"])").command;
  const auto named = [&](const char* flag) {
    for (std::size_t k = 0; k + 1 < command.size(); ++k)
      if (command[k] == flag && command[k + 1] == "parameter.chassis.mass_kg") return true;
    return false;
  };
  EXPECT_TRUE(named("--command"));
  EXPECT_TRUE(named("--measure"));
  for (const char* const wrong :
       {R"("parameter.chassis.mass_kg")", R"(["--stop-s"])", R"(["input.throttle"])", "[1]",
        R"(["parameter.environment.road_grip"])"})
    EXPECT_THROW(drive(wrong), view::Refusal) << wrong;
  EXPECT_THAT(of(R"({"do": "info", "unit": "0/car.fmu"})").command,
              ElementsAre("crgsim", "info", "car.fmu", "--json"));
}

TEST_F(Wish, TheDemoIsMadeOfTheCircuitThatCameWithTheProgram) {
  const view::Folders folders({folder_.path("a")});
  const ordered_json wish{{"do", "demo"}};
  EXPECT_THAT(view::wish_of(wish, folders, "/x/circuit.yaml").command,
              ElementsAre("crgbuild", "synth", "/x/circuit.yaml", "-o", "demo"));
  EXPECT_EQ(status(R"({"do": "demo"})"), 404);
}

TEST_F(Wish, AnythingElseIsRefused) {
  EXPECT_EQ(status("[]"), 400);
  EXPECT_EQ(status(R"({"do": "sh"})"), 400);
  EXPECT_EQ(status(R"({"do": "build"})"), 404);
  EXPECT_EQ(status(R"({"do": "build", "input": "0/../secret.crg"})"), 404);
  EXPECT_EQ(status(R"({"do": "report", "road": "0/ring.crg", "mesh": "--help"})"), 404);
}

TEST_F(Wish, TilesAreOfOneCloudOrOfSeveralThatAreNamed) {
  std::filesystem::create_directories(folder_.path("a/scans"));
  folder_.file("a/survey.las", "");
  for (const char* const name : {"a/scans/1.ply", "a/scans/2.ply", "a/poses.csv"})
    folder_.file(name, "");
  std::filesystem::create_symlink(folder_.path("secret.crg"), folder_.path("a/scans/away.las"));
  EXPECT_THAT(of(R"({"do": "tiles", "clouds": ["0/survey.las"]})").command,
              ElementsAre("lidar2mesh", "tiles", "survey.las", "-o", "out/survey-tiles"));
  const view::Wish several = of(
      R"({"do": "tiles", "clouds": ["0/scans/1.ply", "0/scans/2.ply"], "trajectory": "0/poses.csv"})");
  EXPECT_THAT(several.command, ElementsAre("lidar2mesh", "tiles", "scans/1.ply", "scans/2.ply",
                                           "-o", "out/scans-tiles", "--trajectory", "poses.csv"));
  EXPECT_EQ(several.result, "out/scans-tiles");
  for (const char* const wrong : {R"({"do": "tiles"})", R"({"do": "tiles", "clouds": []})",
                                  R"({"do": "tiles", "clouds": "0/survey.las"})"})
    EXPECT_EQ(status(wrong), 400) << wrong;
  for (const char* const wrong :
       {R"({"do": "tiles", "clouds": [1]})", R"({"do": "tiles", "clouds": ["--help"]})",
        R"({"do": "tiles", "clouds": ["0/scans/away.las"]})",
        R"({"do": "tiles", "clouds": ["0/scans"]})",
        R"({"do": "tiles", "clouds": ["0/survey.las"], "trajectory": "-o"})"})
    EXPECT_EQ(status(wrong), 404) << wrong;
}

TEST_F(Wish, DrivesHaveATableAndAPortOfTheirOwn) {
  folder_.file("a/car.fmu", "");
  const view::Wish first = of(R"({"do": "drive", "unit": "0/car.fmu"})");
  EXPECT_EQ(first.result, "out/drives/car-1.csv");
  EXPECT_GT(first.port, 0);
  folder_.file("a/out/drives/car-1.csv", "");
  EXPECT_EQ(of(R"({"do": "drive", "unit": "0/car.fmu"})").result, "out/drives/car-2.csv");
  EXPECT_THAT(first.command, testing::Not(testing::Contains("--devices")));
  EXPECT_THAT(first.command, testing::Contains("parameter.environment.road_grip"));

  folder_.file("a/devices.yaml", "scans: {}\n");
  folder_.file("a/road.crg", "");
  const view::Wish sees = of(
      R"({"do": "drive", "unit": "0/car.fmu", "devices": "0/devices.yaml", "road": "0/road.crg"})");
  const std::vector<std::string> last(sees.command.end() - 6, sees.command.end());
  EXPECT_THAT(last, testing::ElementsAre("--devices", "devices.yaml", "--road", "road.crg",
                                         "--sights", "out/drives/car-2.sights.jsonl"));
  EXPECT_EQ(status(R"({"do": "drive", "unit": "0/car.fmu", "devices": "0/devices.yaml"})"), 404)
      << "sensors without a road";
}

TEST_F(Wish, NothingIsWrittenThroughALinkOutOfTheFolders) {
  namespace fs = std::filesystem;
  fs::create_directories(folder_.path("home"));
  folder_.file("a/car.fmu", "");
  const char* const build = R"({"do": "build", "input": "0/tracks/oval/track.yaml"})";
  const char* const keep = R"({"do": "keep", "road": "0/ring.crg"})";
  const char* const drive = R"({"do": "drive", "unit": "0/car.fmu"})";
  const char* const stretch =
      R"({"do": "stretch", "input": "0/tracks/oval/track.yaml", "u_begin_m": 0, "u_end_m": 9})";
  fs::create_directory_symlink("../home", folder_.path("a/out"));
  for (const char* const json : {build, keep, drive, stretch}) EXPECT_EQ(status(json), 403) << json;
  EXPECT_TRUE(fs::is_empty(folder_.path("home")));
  // Also through what lies in a folder of results, whether it is there or not.
  fs::remove(folder_.path("a/out"));
  fs::create_directories(folder_.path("a/out/oval"));
  EXPECT_EQ(status(build), 200);
  fs::create_symlink("../../../home/none", folder_.path("a/out/oval/oval.crg"));
  EXPECT_EQ(status(build), 403);
  fs::create_directories(folder_.path("a/out/drives"));
  fs::create_symlink(folder_.path("home/none"), folder_.path("a/out/drives/car-1.csv"));
  EXPECT_EQ(status(drive), 403);
  // A link that stays in the folders is as good as a folder.
  fs::remove_all(folder_.path("a/out"));
  fs::create_directory_symlink("../b", folder_.path("a/out"));
  EXPECT_EQ(status(build), 200);
  fs::remove(folder_.path("a/out"));
  fs::create_directory_symlink("tracks", folder_.path("a/out"));
  EXPECT_EQ(status(build), 200);
}

}  // namespace wish_test
