#include "sim/unit_description.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "some_unit.h"

namespace unit_description_test {

using sim_tests::description_2, sim_tests::description_3, sim_tests::scalar_2, sim_tests::value_3;
using ::testing::HasSubstr;

std::string refusal(const std::string& xml) {
  try {
    sim::read_unit_description(xml, "u.fmu");
  } catch (const base::Error& error) {
    return error.what();
  }
  return "";
}

TEST(UnitDescription, ReadsBothVersions) {
  const sim::UnitDescription two = sim::read_unit_description(
      description_2("g", R"(<ScalarVariable name="v" valueReference="7" causality="parameter"
        variability="tunable" description="of &lt;it&gt;"><Real unit="m/s" start="1.5"/></ScalarVariable>)" +
                             scalar_2("mode", 8, "input", "Enumeration")),
      "u.fmu");
  EXPECT_EQ(two.version, 2);
  EXPECT_EQ(two.token, "g");
  EXPECT_EQ(two.stop_s, 3.0);
  EXPECT_TRUE(two.takes_any_step);
  ASSERT_EQ(two.variables.size(), 2u);
  EXPECT_EQ(two.variables[0].unit, "m/s");
  EXPECT_EQ(two.variables[0].start, "1.5");
  EXPECT_EQ(two.variables[0].description, "of <it>");
  EXPECT_EQ(two.variables[0].variability, "tunable");
  EXPECT_EQ(two.find("mode")->type, sim::ValueType::int32);

  const sim::UnitDescription three = sim::read_unit_description(
      description_3(
          "t", R"(<UInt64 name="n" valueReference="1" causality="structuralParameter" start="3"/>
        <Float64 name="a" valueReference="2" causality="output"><Dimension valueReference="1"/><Dimension start="2"/></Float64>
        <String name="s" valueReference="3" causality="parameter"><Start value="hello"/></String>
        <Clock name="c" valueReference="4"/>)"),
      "u.fmu");
  EXPECT_EQ(three.version, 3);
  EXPECT_EQ(three.find("a")->size, 6u);
  EXPECT_EQ(three.find("s")->start, "hello");
  EXPECT_EQ(three.find("c")->type, sim::ValueType::other);
  EXPECT_EQ(three.find("none"), nullptr);
}

TEST(UnitDescription, RefusesInOneLine) {
  EXPECT_THAT(refusal("<a"), HasSubstr("u.fmu: no XML"));
  EXPECT_THAT(refusal("<a/>"), HasSubstr("fmiModelDescription is missing"));
  EXPECT_THAT(refusal(R"(<fmiModelDescription fmiVersion="1.0"/>)"),
              HasSubstr("FMI version '1.0'"));
  EXPECT_THAT(
      refusal(R"(<fmiModelDescription fmiVersion="2.0"><ModelExchange/></fmiModelDescription>)"),
      HasSubstr("no co-simulation"));
  for (const char* const identifier : {"../../lib/evil", "a/b", "", "a b"})
    EXPECT_THAT(
        refusal(fmt::format(
            R"(<fmiModelDescription fmiVersion="2.0"><CoSimulation modelIdentifier="{}"/></fmiModelDescription>)",
            identifier)),
        HasSubstr("letters, digits and _ wanted"));
  EXPECT_THAT(refusal(description_2("g", scalar_2("x", 1, "output") + scalar_2("x", 2, "output"))),
              HasSubstr("two variables are called 'x'"));
  EXPECT_THAT(refusal(description_2("g", scalar_2("x", -1, "output"))),
              HasSubstr("valueReference of x"));
  EXPECT_THAT(
      refusal(description_3(
          "t",
          R"(<Float64 name="a" valueReference="1"><Dimension start="100000"/><Dimension start="100000"/></Float64>)")),
      HasSubstr("a has more than a million values"));
  EXPECT_THAT(refusal(description_3("t", value_3("Complex", "z", 1, "output"))),
              HasSubstr("type 'Complex'"));
}

TEST(UnitDescription, NamesAndStartsThatLieAreRefusedAndShown) {
  EXPECT_EQ(refusal(description_2("g", scalar_2("a&#10;b", 1, "output"))),
            R"(u.fmu: a variable is called 'a\x0ab'; a name without control characters wanted)");
  EXPECT_THAT(refusal(description_2("g", scalar_2("\x1b[31mred\x07", 1, "output"))),
              HasSubstr(R"('\x1b[31mred\x07')"));
  EXPECT_THAT(refusal(description_3("g", value_3("Float64",
                                                 "\xC2\x9b"
                                                 "1m",
                                                 1, "output"))),
              HasSubstr(R"('\xc2\x9b1m')"));
  const auto start = [](const std::string& type, const std::string& text) {
    return refusal(description_2("g", "<ScalarVariable name=\"v\" valueReference=\"1\"><" + type +
                                          " start=\"" + text + "\"/></ScalarVariable>"));
  };
  EXPECT_EQ(start("Real", "abc"), "u.fmu: the start of v is 'abc'; a number wanted");
  EXPECT_THAT(start("Real", "1.5x"), HasSubstr("a number wanted"));
  EXPECT_THAT(start("Boolean", "yes"), HasSubstr("a number wanted"));
  for (const char* const number : {"1.5", "-2e-3", "+4", " 5 ", "INF", "-INF", "NaN", "1e-400", ""})
    EXPECT_EQ(start("Real", number), "") << number;
  EXPECT_EQ(start("Boolean", "true"), "");
  EXPECT_EQ(start("String", "abc"), "");
  EXPECT_EQ(
      refusal(description_3(
          "t",
          R"(<Float64 name="a" valueReference="1" start="1 2"><Dimension start="2"/></Float64>)")),
      "");
}

}  // namespace unit_description_test
