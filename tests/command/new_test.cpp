// crgdrive new: all files or none, and none over what others wrote.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

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

}  // namespace new_test
