// Data sheets: what is read, and how what cannot be is refused.
#include "vehicle/data_sheet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/run_crgbuild.h"
#include "support/temporary_folder.h"
#include "tyre_size.h"
#include "vehicle/error.h"

namespace data_sheet_test {

using namespace vehicle;  // NOLINT: a test of this library
using ::testing::AllOf;
using ::testing::HasSubstr;

const std::string kSheet =
    "name: car\nkind: road\nmass_kg: 1350\nwheelbase_m: 2.575\nfront_weight: 0.53\n"
    "track_m: [1.52, 1.55]\ntyres: 215/40R18\npower_kw: 173\npower_rpm: 7000\n";

DataSheet read(const std::string& text) {
  const cli::Folder folder;
  cli::write(folder / "car.yaml", text);
  return read_data_sheet(folder / "car.yaml");
}

std::string refusal(const std::string& text) {
  try {
    (void)read(text);
  } catch (const Error& error) {
    return error.what();
  }
  return "taken";
}

/// The sheet with a line in place of the one that has its key.
std::string with(const std::string& line) {
  const std::string key = line.substr(0, line.find(':') + 1);
  const std::size_t at = kSheet.find("\n" + key);
  if (at == std::string::npos) return kSheet + line + "\n";
  return kSheet.substr(0, at + 1) + line + kSheet.substr(kSheet.find('\n', at + 1));
}

TEST(DataSheet, TheExampleIsOne) {
  const DataSheet sheet = read(example_data_sheet());
  EXPECT_EQ(sheet.name, "my_car");
  EXPECT_EQ(sheet.mass_kg, 1350.0);
  EXPECT_EQ(sheet.track_m, (std::array{1.52, 1.55}));
  EXPECT_FALSE(sheet.grip);
  // All that it offers behind a # can be said.
  std::string all = example_data_sheet();
  for (const char* key :
       {"torque_nm", "torque_rpm", "limit_rpm", "turbo", "gears", "final_drive", "differential",
        "cog_height_m", "grip", "drag_area_m2", "downforce_area_m2", "brake_disc_m", "ride_hz",
        "top_speed_kmh", "to_100_kmh_s"}) {
    const std::size_t at = all.find("\n# " + std::string(key) + ":");
    ASSERT_NE(at, std::string::npos) << key;
    all.erase(at + 1, 2);
  }
  const DataSheet stated = read(all);
  EXPECT_EQ(stated.gear_ratios.size(), 6u);
  EXPECT_EQ(stated.grip, 1.0);
  EXPECT_EQ(*stated.brake_disc_m, (std::array{0.30, 0.29}));
  EXPECT_FALSE(stated.curve_guessed);
}

TEST(DataSheet, TorqueGoesThroughItsPeakAndItsPower) {
  const DataSheet sheet = read(kSheet + "torque_nm: 250\ntorque_rpm: 3700\n");
  double peak = 0.0, power_kw = 0.0;
  for (const auto& [rpm, nm] : sheet.torque) {
    peak = std::max(peak, nm);
    power_kw = std::max(power_kw, rpm * nm * 3.14159265 / 30e3);
  }
  EXPECT_NEAR(peak, 250.0, 1.0);
  EXPECT_NEAR(power_kw, 173.0, 3.0);
  const std::string points = "torque_points: {1000: 150, 3000: 250, 7000: 236, 7500: 215}\n";
  std::string no_power = kSheet;
  no_power.resize(no_power.find("power_kw"));
  const DataSheet pointed = read(no_power + points);
  EXPECT_EQ(pointed.power_rpm, 7000.0);
  EXPECT_EQ(pointed.torque.size(), 4u);
  EXPECT_THAT(refusal(kSheet + points), HasSubstr("stands beside torque_points"));
}

// The number, what was seen, what is plausible, and the line.
TEST(DataSheet, RefusesWithTheNumberAndWhatIsPlausible) {
  EXPECT_THAT(refusal(with("front_weight: 53")),
              AllOf(HasSubstr("car.yaml:5: front_weight = 53, plausible is 0.25 to 0.75"),
                    HasSubstr("share of the weight")));
  EXPECT_THAT(refusal(with("mass_kg: 1.35")), HasSubstr("mass_kg = 1.35, plausible is 60 to 6000"));
  EXPECT_THAT(refusal(with("track_m: [1520, 1550]")), HasSubstr("track_m = 1520"));
  EXPECT_THAT(refusal(with("track_m: [1.5, 1.5, 1.5]")), HasSubstr("has 3 numbers, wanted two"));
  EXPECT_THAT(refusal(with("tyres: wide")), HasSubstr("'wide' is no size of a tyre"));
  EXPECT_THAT(refusal(with("kind: truck")), HasSubstr("wanted one of: road, race, formula, kart"));
  EXPECT_THAT(refusal(with("gears: 11")), HasSubstr("gears = 11, wanted 1 to 10"));
  EXPECT_THAT(refusal(with("gears: [1, 2]")), HasSubstr("gears has 2 behind 1"));
  EXPECT_THAT(refusal(with("gears: [3, 2]")), HasSubstr("final_drive is missing"));
  EXPECT_THAT(refusal(with("colour: red")), HasSubstr("'colour' is not a key of a data sheet"));
  EXPECT_THAT(refusal(with("mass_kg: nan")), HasSubstr("wanted a finite number"));
  EXPECT_THAT(refusal(with("brake_disc_m: 0.5")), HasSubstr("the rim of 215/40R18 has 0.457 m"));
  std::string without = kSheet;
  without.replace(without.find("mass_kg: 1350\n"), 14, "");
  EXPECT_THAT(refusal(without), HasSubstr("'mass_kg' is missing: kg"));
}

TEST(DataSheet, RefusesNumbersThatContradictEachOther) {
  EXPECT_THAT(refusal(kSheet + "torque_nm: 200\ntorque_rpm: 3700\n"),
              HasSubstr("173 kW at 7000 rpm are 236 N m, but torque_nm = 200"));
  EXPECT_THAT(refusal(kSheet + "torque_nm: 450\ntorque_rpm: 6000\n"),
              HasSubstr("450 N m at 6000 rpm are 283 kW, but power_kw = 173"));
  EXPECT_THAT(refusal(kSheet + "limit_rpm: 6000\n"),
              HasSubstr("lies below the speed of the greatest power"));
  std::string large = with("tyres: 285/75R24");  // 0.52 m of radius
  large.replace(large.find("2.575"), 5, "1.000");
  EXPECT_THAT(refusal(large), HasSubstr("wheelbase_m = 1 m, but the tyres would touch at 1.037 m"));
}

TEST(TyreSize, IsReadAsTyresAreSold) {
  const auto is = [](const char* name, double radius_m, double width_m, double rim_m) {
    const auto size = tyre_size(name);
    ASSERT_TRUE(size) << name;
    EXPECT_NEAR(size->radius_m, radius_m, 1e-4) << name;
    EXPECT_NEAR(size->width_m, width_m, 1e-4) << name;
    EXPECT_NEAR(size->rim_m, rim_m, 1e-4) << name;
  };
  is("215/40R18", 0.5 * 0.4572 + 0.086, 0.215, 0.4572);
  is("215/40 ZR 18 89Y", 0.5 * 0.4572 + 0.086, 0.215, 0.4572);
  is("325/705R18", 0.3525, 0.325, 0.4572);
  is("30/68-18", 0.34, 0.30, 0.4572);
  is("18x7.5-10", 0.2286, 0.1905, 0.254);
  for (const char* name : {"", "18", "215-40-18", "215/40", "900/40R18", "0x0-0", "215/40R99"})
    EXPECT_FALSE(tyre_size(name)) << name;
}

}  // namespace data_sheet_test
