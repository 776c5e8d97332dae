#include "fmu/export_unit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <pugixml.hpp>

#include "base/read_file.h"
#include "driven_car.h"
#include "fmu/instance.h"
#include "support/run_tool.h"
#include "unit_under_test.h"

namespace export_unit_test {

using fmu_tests::Unit;
using support::run_tool, support::ToolRun;
using Words = std::vector<std::string>;
using ::testing::HasSubstr;

TEST(ExportUnit, IsTheSameEachTimeAndKnowsItsContents) {
  const Unit one, other;
  EXPECT_TRUE(one.exported().bytes == other.exported().bytes);
  const Unit plane(fmu::Version::kFmi2, false), third(fmu::Version::kFmi3);
  EXPECT_NE(one.token(), plane.token());
  EXPECT_NE(one.token(), third.token());
  EXPECT_EQ(one.exported().variables, fmu::count_values(fmu::variables()));
  EXPECT_LT(third.exported().variables, one.exported().variables);
  for (const char* name : {"resources/unit.txt", "resources/road.crg", "resources/car/vehicle.yaml",
                           "resources/car/front.tir", "resources/car/setup.txt"})
    EXPECT_TRUE(one.files().contains(name)) << name;
  EXPECT_EQ(one.files().at("resources/road.crg"), one.folder().read("circle.crg"));
}

TEST(ExportUnit, BringsFilesOfOtherFoldersAndRefusesAbsoluteOnes) {
  const support::TemporaryFolder folder;
  std::filesystem::create_directories(folder.path("cars/one"));
  for (const auto& entry :
       std::filesystem::directory_iterator(places::source() + "/vehicles/open_wheel"))
    std::filesystem::copy(entry.path(), folder.path("cars/one/"));
  std::filesystem::rename(folder.path("cars/one/front.tir"), folder.path("front.tir"));
  std::string car = folder.read("cars/one/vehicle.yaml");
  const std::size_t at = car.find("front.tir");
  fmu::ExportOptions options;
  options.vehicle_path = folder.file("cars/one/vehicle.yaml", car.replace(at, 0, "../../"));
  options.binary_path = places::kerbstone_car();
  const fmu::Exported unit = fmu::export_unit(options);
  EXPECT_THAT(unit.files, ::testing::Contains("resources/car/front.tir"));
  EXPECT_THAT(unit.files, ::testing::Contains("resources/car/cars/one/vehicle.yaml"));
  const auto files = fmu_tests::unpacked(folder.file("car.fmu", unit.bytes));
  for (const auto& [name, bytes] : files) {
    std::filesystem::create_directories(
        std::filesystem::path(folder.path("unit/" + name)).parent_path());
    folder.file("unit/" + name, bytes);
  }
  std::filesystem::remove_all(folder.path("cars"));
  EXPECT_NO_THROW(fmu::Instance(folder.path("unit/resources"), unit.token));
}

TEST(ExportUnit, ByTheToolRunsWithSetupAndSettingsInIt) {
  const support::TemporaryFolder folder;
  const std::string out = folder.path("car.fmu");
  const ToolRun made =
      run_tool(places::crgdrive(),
               {"fmu", places::source() + "/vehicles/open_wheel/vehicle.yaml", "-o", out, "--setup",
                folder.file("setup.txt", "front.spring_npm = 222222\n"), "--set", "wind=0", "--set",
                "rear.spring_npm=111111", "--contact", "four-point", "--step-s", "0.0005"});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_THAT(made.out, HasSubstr("FMI 2.0 co-simulation, "));
  const auto files = fmu_tests::unpacked(out);
  EXPECT_EQ(files.at("resources/setup.txt"),
            "front.spring_npm = 222222\nrear.spring_npm = 111111\nwind = 0\n");
  EXPECT_THAT(files.at("resources/unit.txt"), HasSubstr("contact = four-point\n"));
  EXPECT_THAT(files.at("resources/unit.txt"), HasSubstr("solver.step = 0.0005\n"));
  EXPECT_THAT(files.at("modelDescription.xml"), HasSubstr("<Real unit=\"N/m\" min="));
  // The starts that are described are those that the unit has.
  for (const auto& [name, bytes] : files) {
    std::filesystem::create_directories(
        std::filesystem::path(folder.path("unit/" + name)).parent_path());
    folder.file("unit/" + name, bytes);
  }
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(files.at("modelDescription.xml").c_str()));
  const pugi::xml_node root = document.child("fmiModelDescription");
  fmu::Instance unit(folder.path("unit/resources"), root.attribute("guid").value());
  std::size_t compared = 0;
  for (const pugi::xml_node v : root.child("ModelVariables")) {
    const pugi::xml_node real = v.child("Real");
    if (!real.attribute("start")) continue;
    EXPECT_EQ(unit.number(v.attribute("valueReference").as_uint(), fmu::Type::kReal),
              real.attribute("start").as_double())
        << v.attribute("name").value();
    ++compared;
  }
  EXPECT_GT(compared, 200u);
  EXPECT_EQ(unit.number(fmu_tests::reference_of("parameter.rear.spring_npm"), fmu::Type::kReal),
            111111);
  const ToolRun missing = run_tool(places::crgdrive(), {"fmu", "none.yaml", "-o", out});
  EXPECT_EQ(missing.code, 1);
  const ToolRun alone =
      run_tool(places::crgdrive(), {"fmu", places::source() + "/vehicles/open_wheel/vehicle.yaml",
                                    "-o", out, "--grip", folder.file("f.crg", "")});
  EXPECT_EQ(alone.code, 1);
  EXPECT_THAT(alone.err, HasSubstr("a friction map without a road; give --road"));
}

// Somebody else's importer, beside the checkout.
TEST(ExportUnit, RunsInFmusim) {
  const std::string fmusim = places::data() + "/../tools/fmusim";
  if (!std::filesystem::exists(fmusim)) GTEST_SKIP() << "no " << fmusim;
  std::vector<std::string> last;
  for (const fmu::Version version : {fmu::Version::kFmi2, fmu::Version::kFmi3}) {
    const Unit unit(version);
    const std::string result = unit.folder().path("result.csv");
    const ToolRun run = run_tool(fmusim, {"--stop-time",
                                          "60",
                                          "--output-interval",
                                          "0.001",
                                          "--start-value",
                                          "start.speed",
                                          "10",
                                          "--start-value",
                                          "input.steering",
                                          "0.05",
                                          "--start-value",
                                          "input.throttle",
                                          "0.1",
                                          "--output-variable",
                                          "car.x",
                                          "--output-variable",
                                          "car.vx",
                                          "--output-file",
                                          result,
                                          unit.folder().path("car.fmu")});
    EXPECT_EQ(run.code, 0) << run.out << run.err;
    const std::string rows = unit.folder().read("result.csv");
    last.push_back(rows.substr(rows.rfind('\n', rows.size() - 2)));
    if (version == fmu::Version::kFmi3) continue;
    fmu_tests::DrivenCar own(unit.folder().path("circle.crg"));
    vehicle::Controls<double> asked;
    asked.steer_command_rad = 0.05;
    asked.throttle_command = 0.1;
    for (int i = 0; i < 60000; ++i) own.step(asked);
    double time_s = 0.0, x_m = 0.0, vx_mps = 0.0;
    ASSERT_EQ(std::sscanf(last[0].c_str(), "%lf,%lf,%lf", &time_s, &x_m, &vx_mps), 3) << last[0];
    EXPECT_NEAR(time_s, 60.0, 1e-9);
    EXPECT_NEAR(x_m, own.row()[3], 1e-12);
    EXPECT_NEAR(vx_mps, own.row()[9], 1e-12);
  }
  EXPECT_EQ(last[0], last[1]);
}

// Half the run, its state in a file, the other half by another process from that file.
TEST(ExportUnit, FmusimGoesOnFromASavedState) {
  const std::string fmusim = places::data() + "/../tools/fmusim";
  if (!std::filesystem::exists(fmusim)) GTEST_SKIP() << "no " << fmusim;
  for (const fmu::Version version : {fmu::Version::kFmi2, fmu::Version::kFmi3}) {
    const Unit unit(version);
    const auto path = [&](const char* name) { return unit.folder().path(name); };
    const auto simulate = [&](const char* begin_s, const char* end_s, Words more) {
      Words words{"--start-time",      begin_s, "--stop-time",   end_s,
                  "--output-interval", "0.25",  "--output-file", path("result.csv")};
      words.insert(words.end(), more.begin(), more.end());
      words.push_back(path("car.fmu"));
      const ToolRun run = run_tool(fmusim, words);
      EXPECT_EQ(run.code, 0) << run.out << run.err;
    };
    const Words drive{"--start-value", "start.speed",    "10",
                      "--start-value", "input.steering", "0.05",
                      "--start-value", "input.throttle", "0.1"};
    const auto with = [](Words words, const Words& more) {
      words.insert(words.end(), more.begin(), more.end());
      return words;
    };
    simulate("0", "4", with(drive, {"--final-fmu-state-file", path("whole")}));
    simulate("0", "2", with(drive, {"--final-fmu-state-file", path("half")}));
    simulate("2", "4",
             {"--initial-fmu-state-file", path("half"), "--final-fmu-state-file", path("other")});
    EXPECT_TRUE(unit.folder().read("other") == unit.folder().read("whole"));
    EXPECT_FALSE(unit.folder().read("half") == unit.folder().read("whole"));
    EXPECT_GT(unit.folder().read("whole").size(), 10000u);
  }
}

}  // namespace export_unit_test
