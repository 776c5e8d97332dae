#include "fmu/unit_definition.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"

namespace unit_definition_test {

TEST(UnitDefinition, TakesUnitsApart) {
  const auto expect = [](const char* unit, int kg, int m, int s, int K, int rad, double factor) {
    const fmu::UnitDefinition d = fmu::define_unit(unit);
    EXPECT_EQ(d.kg, kg) << unit;
    EXPECT_EQ(d.m, m) << unit;
    EXPECT_EQ(d.s, s) << unit;
    EXPECT_EQ(d.K, K) << unit;
    EXPECT_EQ(d.rad, rad) << unit;
    EXPECT_DOUBLE_EQ(d.factor, factor) << unit;
  };
  expect("1", 0, 0, 0, 0, 0, 1);
  expect("kg.m2", 1, 2, 0, 0, 0, 1);
  expect("N m s", 1, 2, -1, 0, 0, 1);
  expect("J/(K.m)", 1, 1, -2, -1, 0, 1);
  expect("W/K", 1, 2, -3, -1, 0, 1);
  expect("1/MJ", -1, -2, 2, 0, 0, 1e-6);
  expect("Pa s", 1, -1, -1, 0, 0, 1);
  expect("rad/s", 0, 0, -1, 0, 1, 1);
  expect("m/s2", 0, 1, -2, 0, 0, 1);
}

TEST(UnitDefinition, RefusesWhatItDoesNotKnow) {
  for (const char* unit : {"", "furlong", "m/s/s", "kg m^2"})
    EXPECT_THAT([&] { fmu::define_unit(unit); },
                ::testing::ThrowsMessage<base::Error>(::testing::HasSubstr("is not known")))
        << unit;
}

}  // namespace unit_definition_test
