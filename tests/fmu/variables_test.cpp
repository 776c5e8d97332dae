#include "fmu/variables.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <set>

#include "recording/channels.h"
#include "vehicle/parameters.h"
#include "vehicle/state.h"

namespace variables_test {

using fmu::Source, fmu::Variable;

TEST(Variables, HoldEveryChannelStateParameterAndTermOnce) {
  std::map<Source, std::size_t> values;
  std::uint32_t reference = 0;
  for (const Variable& v : fmu::variables()) {
    EXPECT_EQ(v.reference, reference) << v.name;
    EXPECT_EQ(v.index, values[v.source]) << v.name;
    reference += static_cast<std::uint32_t>(v.size);
    values[v.source] += v.size;
  }
  EXPECT_EQ(reference, fmu::count_values(fmu::variables()));
  EXPECT_EQ(values[Source::kTelemetry], recording::telemetry_channels().size());
  EXPECT_EQ(values[Source::kState], vehicle::kStateSize);
  EXPECT_EQ(values[Source::kRate], vehicle::kStateSize);
  EXPECT_EQ(values[Source::kParameter], vehicle::kParameterCount);
  EXPECT_EQ(values[Source::kTerm], vehicle::kTermCount);
  EXPECT_EQ(values[Source::kText], fmu::kTextCount);
}

TEST(Variables, HaveStructuredNamesOfTheirOwnAndMeanings) {
  const std::string plain =
      R"([A-Za-z_][A-Za-z0-9_]*(\[\d+\])?(\.[A-Za-z_][A-Za-z0-9_]*(\[\d+\])?)*)";
  const std::regex structured(plain + R"(|der\()" + plain + R"(\))");
  std::set<std::string> names, arrays;
  for (const Variable& v : fmu::variables()) {
    EXPECT_TRUE(arrays.insert(fmu::array_name(v)).second) << v.name;
    EXPECT_TRUE(std::regex_match(fmu::array_name(v), structured)) << fmu::array_name(v);
    EXPECT_GE(v.text.size(), 4u) << v.name;
    EXPECT_EQ(v.text.find_first_of("\n\t"), std::string::npos);
    for (std::size_t i = 0; i < v.size; ++i) {
      const std::string name = fmu::value_name(v, i);
      EXPECT_TRUE(names.insert(name).second) << name;
      EXPECT_TRUE(std::regex_match(name, structured)) << name;
    }
    EXPECT_TRUE(v.start >= v.low && v.start <= v.high) << v.name;
  }
  for (const char* name :
       {"time", "input.steering", "input.brake.fl", "input.opponent[4].x", "wheel.rr.fz",
        "wheel.fl.tyre_temperature", "wheel.fl.spin", "car.yaw_rate", "state.wheel.rl.slip_x",
        "der(state.wheel.rl.slip_x)", "parameter.chassis.mass_kg", "term.wind", "start.u",
        "solver.step", "road"})
    EXPECT_TRUE(names.contains(name)) << name;
  EXPECT_TRUE(arrays.contains("wheel.fz"));
  EXPECT_TRUE(arrays.contains("input.opponent.x"));
}

}  // namespace variables_test
