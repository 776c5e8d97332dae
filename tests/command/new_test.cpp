// crgdrive new: all files or none, and none over what others wrote.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "crg/file.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "support/run_tool.h"

namespace new_test {

using cli::Folder;
using support::run_tool, support::ToolRun;
using ::testing::HasSubstr;

TEST(New, WritesAllFilesOrNone) {
  const Folder folder;
  const std::string sheet = folder / "car.yaml", car = folder / "car";
  cli::write(sheet, run_tool(places::crgdrive(), {"new", "--example"}).out);
  const ToolRun made = run_tool(places::crgdrive(), {"new", sheet, "-o", car});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_THAT(made.out, HasSubstr("0 to 100 km/h in "));
  for (const char* name : {"vehicle.yaml", "front.tir", "rear.tir", "engine.csv"})
    EXPECT_TRUE(cli::exists(car + "/" + name)) << name;
  const std::string before = cli::read(car + "/vehicle.yaml");
  EXPECT_EQ(run_tool(places::crgdrive(), {"new", sheet, "-o", car}).code, 0);
  EXPECT_EQ(cli::read(car + "/vehicle.yaml"), before);

  // What a user changed, or what was there before, stays.
  cli::write(car + "/front.tir", "mine");
  const ToolRun again = run_tool(places::crgdrive(), {"new", sheet, "-o", car});
  EXPECT_EQ(again.code, 1);
  EXPECT_THAT(again.err, HasSubstr("front.tir: lies there already"));
  EXPECT_EQ(cli::read(car + "/front.tir"), "mine");

  // A sheet that cannot be leaves no folder.
  std::string bad = cli::read(sheet);
  bad.replace(bad.find("front_weight: 0.53"), 18, "front_weight: 53");
  cli::write(sheet, bad);
  const ToolRun refused = run_tool(places::crgdrive(), {"new", sheet, "-o", folder / "none"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.err, HasSubstr("car.yaml:7: front_weight = 53, plausible is 0.25 to 0.75"));
  EXPECT_FALSE(cli::exists(folder / "none"));
}

TEST(New, TakesAnyNameAndRefusesWhatIsNoCarByTheSheet) {
  const Folder folder;
  const std::string sheet = folder / "car.yaml";
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = run_tool(places::crgdrive(), {"new", "--example"}).out;
    text.replace(text.find(from), from.size(), to);
    cli::write(sheet, text);
    return run_tool(places::crgdrive(), {"new", sheet, "-o", folder / "car"});
  };
  EXPECT_EQ(with("name: my_car", "name: \"Anna's: car # 7\\nterms: {}\"").code, 0);
  EXPECT_THAT(cli::read(folder / "car/vehicle.yaml"),
              HasSubstr("\nname: 'Anna''s: car # 7\\x0aterms: {}'\n"));
  EXPECT_EQ(with("[215/40R18, ", "[\"215/40R18\\n[MODEL]\\nFITTYP=99\", ").code, 0);
  EXPECT_THAT(cli::read(folder / "car/front.tir"), HasSubstr("$ 215/40R18\\x0a[MODEL]"));
  const ToolRun weak = with("power_kw: 173", "power_kw: 1");
  EXPECT_EQ(weak.code, 1);
  EXPECT_THAT(weak.err, HasSubstr("car.yaml: 1350 kg want a first gear of "));
}

TEST(New, SaysWhatIsFarFromWhatIsPublished) {
  const Folder folder;
  const std::string sheet = folder / "car.yaml";
  cli::write(sheet, run_tool(places::crgdrive(), {"new", "--example"}).out +
                        "top_speed_kmh: 150\nto_100_kmh_s: 6.3\n");
  const ToolRun made = run_tool(places::crgdrive(), {"new", sheet, "-o", folder / "car"});
  EXPECT_EQ(made.code, 0);
  EXPECT_THAT(made.err, HasSubstr("the car's top speed is 2"));
  EXPECT_THAT(made.err, HasSubstr("the sheet says 150"));
  EXPECT_THAT(made.err, ::testing::Not(HasSubstr("time to 100")));
}

/// A column of a table without comments.
std::vector<double> column_of(const std::string& path, const std::string& name) {
  std::istringstream lines(cli::read(path));
  std::vector<double> out;
  std::ptrdiff_t at = -1;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("#")) continue;
    std::vector<std::string> cells;
    std::istringstream words(line);
    for (std::string cell; std::getline(words, cell, ',');) cells.push_back(cell);
    if (at < 0)
      at = std::find(cells.begin(), cells.end(), name) - cells.begin();
    else
      out.push_back(std::stod(cells.at(static_cast<std::size_t>(at))));
  }
  return out;
}

// Eight gears, on a straight, by each program: in the last the engine turns as the ratio says.
TEST(New, ACarOfEightGearsDrivesInTheLast) {
  const Folder folder;
  const std::string car = folder / "car/vehicle.yaml", road = folder / "road.crg",
                    lap = folder / "lap.csv", run = folder / "run.csv", unit = folder / "car.fmu";
  cli::write(folder / "car.yaml", run_tool(places::crgdrive(), {"new", "--example"}).out +
                                      "gears: [4, 3, 2.3, 1.8, 1.4, 1.15, 0.95, 0.8]\n"
                                      "final_drive: 5\n");
  ASSERT_EQ(run_tool(places::crgdrive(), {"new", folder / "car.yaml", "-o", folder / "car"}).code,
            0);
  crg::ReferenceLine line;
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = 1.0;
  grid.v_m = {-5, 0, 5};
  for (int i = 0; i <= 300; ++i) {
    line.x_m.push_back(i), line.y_m.push_back(0.0), line.heading_rad.push_back(0.0);
    grid.z_m.insert(grid.z_m.end(), 3, 0.0f);
  }
  crg::write(crg::make_crg(line, grid), road, crg::Format::KRBI);

  const ToolRun driven =
      run_tool(places::crgdrive(), {"lap", "--car", car, "--road", road, "-o", lap});
  ASSERT_EQ(driven.code, 0) << driven.err;
  EXPECT_EQ(column_of(lap, "gear").back(), 8.0);
  ASSERT_EQ(run_tool(places::crgdrive(), {"fmu", car, "-o", unit}).code, 0);
  for (const std::string& driven_by : {car, unit}) {
    const auto engine_in = [&](const std::string& gear) {
      const ToolRun ran =
          run_tool(places::crgsim(), {"run", driven_by, "--set", "start.speed=50", "--set",
                                      "input.gear=" + gear, "--record", "car.gear", "--record",
                                      "car.engine", "--stop-s", "0.2", "-o", run});
      EXPECT_EQ(ran.code, 0) << ran.err;
      EXPECT_EQ(column_of(run, "car.gear").back(), std::stod(gear));
      return column_of(run, "car.engine").back();
    };
    EXPECT_NEAR(engine_in("7") / engine_in("8"), 0.95 / 0.8, 0.005);
  }
}

}  // namespace new_test
