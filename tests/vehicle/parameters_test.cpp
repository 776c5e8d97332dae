#include "vehicle/parameters.h"

#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>

#include "support/places.h"

namespace parameters_test {

using namespace vehicle;  // NOLINT: a test of this library

TEST(Parameters, AreNamedOnceWithBoundsAroundTheirDefaults) {
  std::set<std::string_view> names;
  for (const ParameterInfo& p : parameter_list()) {
    EXPECT_TRUE(names.insert(p.name).second) << p.name;
    EXPECT_LE(p.low, p.value) << p.name;
    EXPECT_GE(p.high, p.value) << p.name;
    EXPECT_GT(p.prior, 0.0) << p.name;
    EXPECT_FALSE(p.text.empty()) << p.name;
    EXPECT_EQ(parameter_list()[static_cast<std::size_t>(*find_parameter(p.name))].name, p.name);
  }
  EXPECT_FALSE(find_parameter("chassis.mass"));
}

TEST(Parameters, GiveTheRearAxleWhatTheFrontHas) {
  Parameters<double> p = default_parameters();
  p[Parameter::front_spring_npm] = 1;
  p[Parameter::rear_spring_npm] = 2;
  EXPECT_EQ(p.axle(0, Parameter::front_spring_npm), 1);
  EXPECT_EQ(p.axle(1, Parameter::front_spring_npm), 2);
}

TEST(Parameters, AreDocumentedAsListed) {
  std::ifstream in(places::source() + "/docs/vehicle_parameters.md");
  std::ostringstream text;
  text << in.rdbuf();
  EXPECT_EQ(text.str(), describe_parameters())
      << "run crgdrive parameters > docs/vehicle_parameters.md";
}

TEST(Terms, AreNamedOnce) {
  std::set<std::string_view> names;
  for (const TermInfo& t : term_list()) {
    EXPECT_TRUE(names.insert(t.name).second) << t.name;
    EXPECT_EQ(term_list()[static_cast<std::size_t>(*find_term(t.name))].name, t.name);
  }
  EXPECT_EQ(default_amplitudes()[Term::locked_differential], 0.0);
}

}  // namespace parameters_test
