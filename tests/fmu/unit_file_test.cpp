#include "fmu/unit_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"

namespace unit_file_test {

TEST(UnitFile, ComesBackAsItWas) {
  fmu::UnitFile unit;
  unit.token = "{1-2}";
  unit.texts[static_cast<std::size_t>(fmu::Text::kVehicle)] = "car/a = b.yaml";
  unit.numbers = {{"start.u", 0.1 + 0.2}, {"solver.step", 0.0005}};
  const fmu::UnitFile back =
      fmu::parse_unit_file(fmu::format_unit_file(unit), "unit.txt", fmu::variables());
  EXPECT_EQ(back.token, unit.token);
  EXPECT_EQ(back.texts, unit.texts);
  ASSERT_EQ(back.numbers.size(), 2u);
  EXPECT_EQ(back.numbers[0].value, 0.1 + 0.2);
  EXPECT_EQ(back.numbers[1].name, "solver.step");
}

TEST(UnitFile, RefusesByLine) {
  const auto expect = [](const char* bytes, const char* words) {
    EXPECT_THAT([&] { fmu::parse_unit_file(bytes, "unit.txt", fmu::variables()); },
                ::testing::ThrowsMessage<base::Error>(::testing::HasSubstr(words)))
        << bytes;
  };
  expect("", "no token");
  expect("token = x\nnonsense\n", "unit.txt:2: wanted name = value");
  expect("token = x\nstart.w = 1\n", "unit.txt:2: there is no parameter 'start.w'");
  expect("token = x\nwheel.fl.fz = 1\n", "there is no parameter");
  expect("token = x\nsolver.step = nan\n", "solver.step = 'nan', wanted 1e-05 to 0.01");
  expect("token = x\nstart.fuel = 1e9\n", "start.fuel = '1e9'");
}

}  // namespace unit_file_test
