#include "vehicle/tyre_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <string>

#include "support/places.h"
#include "tyre_files.h"
#include "vehicle/error.h"

namespace tyre_file_test {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// What parse_tyre says about `text`, or "" when it accepts it.
std::string refusal(const std::string& text) {
  try {
    vehicle::parse_tyre(text, "t.tir");
  } catch (const vehicle::Error& error) {
    return error.what();
  }
  return "";
}

std::string with(std::string text, const std::string& old, const std::string& replacement) {
  const std::size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return text.replace(at, old.size(), replacement);
}

TEST(TyreFile, OtherValuesTakeTheirPlaceAndEverythingElseStays) {
  const std::string text = test_tyre_text();
  const std::string changed =
      vehicle::with_tyre_values(text, {{"UNLOADED_RADIUS", 0.31}, {"MASS", 12.5}, {"LGAY", 1.25}});
  const auto before = vehicle::parse_tyre(text, "before").coefficients,
             after = vehicle::parse_tyre(changed, "after").coefficients;
  EXPECT_EQ(after.unloaded_radius_m, 0.31);
  EXPECT_EQ(after.mass_kg, 12.5);  // not the unit of the same name
  EXPECT_EQ(after.lgay, 1.25);
#define VEHICLE_TYRE_COEFFICIENT(member, keyword, fallback)                            \
  if (std::string(#keyword) != "UNLOADED_RADIUS" && std::string(#keyword) != "MASS" && \
      std::string(#keyword) != "LGAY") {                                               \
    EXPECT_EQ(after.member, before.member) << #keyword;                                \
  }
#include "vehicle/tyre_coefficients.def"
#undef VEHICLE_TYRE_COEFFICIENT
  EXPECT_EQ(after.version, before.version);
  EXPECT_EQ(after.left_side, before.left_side);
  EXPECT_EQ(vehicle::with_tyre_values(text, {}), text);
  // Line ends of other systems, small letters, a remark that looks like a value, no end of line.
  EXPECT_EQ(vehicle::with_tyre_values("[MODEL]\r\n$ LMUY = 1\r\nlmuy = 1 $ as measured\r\nLKY = 1",
                                      {{"LMUY", 0.9}}),
            "[MODEL]\r\n$ LMUY = 1\r\nLMUY = 0.9\r\nLKY = 1");
  EXPECT_EQ(vehicle::with_tyre_values("LKY = 1", {{"LCY", 1.1}}),
            "LKY = 1\n[CORRECTED]\nLCY = 1.1\n");
}

TEST(TyreFile, TakesEveryCoefficientAsWritten) {
  const vehicle::TyreFile file = vehicle::parse_tyre(test_tyre_text(), "t.tir");
  EXPECT_EQ(file.coefficients.version, 61);
  EXPECT_TRUE(file.coefficients.left_side);
  EXPECT_EQ(file.coefficients.pcx1, 1.6);
  EXPECT_EQ(file.coefficients.pky1, -45);
  EXPECT_EQ(file.coefficients.ssz2, 0.02);
  EXPECT_EQ(file.coefficients.lmux, 1.0);
  EXPECT_THAT(file.defaulted, AllOf(Contains("LMUX"), Not(Contains("PCX1"))));
  EXPECT_THAT(file.unused, ElementsAre("MASS", "IYY", "FZMIN"));  // what no formula takes is said
}

TEST(TyreFile, ReadsTheOtherVersionsAndWaysOfWriting) {
  EXPECT_EQ(vehicle::parse_tyre(with(test_tyre_text(), "FITTYP = 61", "FITTYP=5"), "t")
                .coefficients.version,
            52);
  // 6 and 21 are 5.2 in the programs of the formula's authors, 60 and 61 are 6.x.
  for (const auto& [code, version] : {std::pair{"6", 52}, {"21", 52}, {"60", 61}})
    EXPECT_EQ(vehicle::parse_tyre(
                  with(test_tyre_text(), "FITTYP = 61", std::string("FITTYP = ") + code), "t")
                  .coefficients.version,
              version)
        << code;
  EXPECT_EQ(vehicle::parse_tyre(with(test_tyre_text(), "FITTYP = 61", "fittyp = +62.0"), "t")
                .coefficients.version,
            62);
  std::string crlf;
  for (const char c : test_tyre_text()) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(vehicle::parse_tyre(crlf, "t").coefficients.pcy1, 1.5);
  const auto file = vehicle::parse_tyre(test_tyre_text() + "N_TIRE_STATES = 4\n", "t");
  EXPECT_THAT(file.unused, Contains("N_TIRE_STATES"));
}

TEST(TyreFile, RefusesWithPlaceAndReason) {
  const std::string text = test_tyre_text();
  EXPECT_THAT(refusal(""), HasSubstr("FITTYP"));
  EXPECT_THAT(refusal(with(text, "FITTYP = 61", "FITTYP = 2002")),
              AllOf(HasSubstr("t.tir:10:"), HasSubstr("2002"), HasSubstr("61")));
  EXPECT_THAT(refusal(with(text, "PCX1 = 1.6", "PCX1 = 1,6")),
              AllOf(HasSubstr("PCX1"), HasSubstr("1,6"), HasSubstr("finite number")));
  EXPECT_THAT(refusal(with(text, "PKY1 = -45", "PKY1 = nan")), HasSubstr("finite number"));
  EXPECT_THAT(refusal(with(text, "PKY1 = -45", "PKY1 = 1e999")), HasSubstr("finite number"));
  EXPECT_THAT(refusal(with(text, "PKY1 = -45\n", "")), HasSubstr("PKY1 is missing"));
  EXPECT_THAT(refusal(with(text, "LENGTH = 'meter'", "LENGTH = 'mile'")),
              AllOf(HasSubstr("t.tir:4:"), HasSubstr("MILE"), HasSubstr("METER")));
  EXPECT_THAT(refusal(with(text, "MASS = 10", "MASS = -10")),
              AllOf(HasSubstr("MASS = -10"), HasSubstr("0 or more")));
  EXPECT_THAT(refusal(with(text, "UNLOADED_RADIUS = 0.3", "UNLOADED_RADIUS = 0")),
              HasSubstr("UNLOADED_RADIUS is 0 m"));
  EXPECT_THAT(refusal(text + "PCX1 = 1.7\n"), AllOf(HasSubstr("contradicts"), HasSubstr("PCX1")));
  EXPECT_THAT(refusal(text + "PCX1 = 1.6\n"), "");
  EXPECT_THAT(refusal(with(text, "FZMAX = 9000", "FZMAX = -1")), HasSubstr("FZMAX"));
  EXPECT_THAT(refusal(with(text, "NOMPRES = 150000", "NOMPRES = 0")), HasSubstr("NOMPRES"));
  EXPECT_THAT(refusal(text + "gibberish\n"), HasSubstr("neither a section"));
  EXPECT_THAT(refusal(text + std::string("X\0Y = 1\n", 8)), HasSubstr("zero byte"));
  EXPECT_THROW(vehicle::read_tyre("/nonexistent/t.tir"), vehicle::Error);
  EXPECT_THROW(vehicle::read_tyre("/"), vehicle::Error);
}

TEST(TyreFile, EndsInAnErrorOrATyreWhateverTheBytes) {
  const std::string text = test_tyre_text();
  for (std::size_t length = 0; length < text.size(); length += 7)
    (void)refusal(text.substr(0, length));
  std::mt19937 random(1);
  for (int trial = 0; trial < 500; ++trial) {
    std::string mutated = text;
    for (int i = 0; i < 5; ++i) mutated[random() % mutated.size()] = static_cast<char>(random());
    (void)refusal(mutated);
  }
}

TEST(TyreFile, ReadsTheSampleFiles) {
  const std::string folder = places::data() + "/tyre/";
  if (!std::filesystem::exists(folder + "sample_mf61.tir"))
    GTEST_SKIP() << "no sample tyre files in " << folder;
  EXPECT_EQ(vehicle::read_tyre(folder + "sample_mf61.tir").coefficients.version, 61);
  const auto file = vehicle::read_tyre(folder + "sample_mf62.tir");
  EXPECT_EQ(file.coefficients.version, 62);
  EXPECT_EQ(file.coefficients.pdy1, 1.0085);
}

}  // namespace tyre_file_test
