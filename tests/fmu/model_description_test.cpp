// The rules of the published schemas and of the standards' text, as far as they touch this unit.
#include "fmu/model_description.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <pugixml.hpp>
#include <set>
#include <sstream>

#include "unit_under_test.h"
#include "vehicle/state.h"

namespace model_description_test {

pugi::xml_document parsed(const fmu_tests::Unit& unit) {
  pugi::xml_document out;
  const pugi::xml_parse_result result =
      out.load_string(unit.files().at("modelDescription.xml").c_str());
  EXPECT_TRUE(result) << result.description();
  return out;
}

/// The names of an element's children come in this order, each as often as it likes.
void expect_order(const pugi::xml_node& parent, const std::vector<std::string>& order) {
  std::size_t at = 0;
  for (const pugi::xml_node child : parent) {
    while (at < order.size() && order[at] != child.name()) ++at;
    ASSERT_LT(at, order.size()) << child.name() << " in " << parent.name();
  }
}

std::set<std::string> units_of(const pugi::xml_node& root) {
  std::set<std::string> out;
  for (const pugi::xml_node unit : root.child("UnitDefinitions")) {
    EXPECT_TRUE(out.insert(unit.attribute("name").value()).second);
    EXPECT_TRUE(unit.child("BaseUnit"));
  }
  return out;
}

void expect_bounds(const pugi::xml_node& typed) {
  for (const char* start = typed.attribute("start").value(); *start != 0;) {
    char* end = nullptr;
    const double value = std::strtod(start, &end);
    if (end == start) break;  // true, false
    if (typed.attribute("min")) {
      EXPECT_GE(value, typed.attribute("min").as_double());
    }
    if (typed.attribute("max")) {
      EXPECT_LE(value, typed.attribute("max").as_double());
    }
    EXPECT_TRUE(std::isfinite(value));
    start = end;
  }
}

TEST(ModelDescription, OfFmi2KeepsTheRules) {
  const fmu_tests::Unit unit;
  const pugi::xml_document document = parsed(unit);
  const pugi::xml_node root = document.child("fmiModelDescription");
  EXPECT_STREQ(root.attribute("fmiVersion").value(), "2.0");
  EXPECT_EQ(root.attribute("guid").value(), unit.token());
  EXPECT_STREQ(root.attribute("modelName").value(), "open_wheel");
  expect_order(root, {"CoSimulation", "UnitDefinitions", "LogCategories", "DefaultExperiment",
                      "ModelVariables", "ModelStructure"});
  EXPECT_TRUE(unit.files().contains(
      std::string("binaries/linux64/") +
      root.child("CoSimulation").attribute("modelIdentifier").value() + ".so"));
  const std::set<std::string> units = units_of(root);
  std::set<std::string> names;
  std::set<unsigned> references;
  std::vector<unsigned> outputs, rates, unknowns;
  std::map<unsigned, unsigned> state_of;  // by the index of its rate
  std::map<unsigned, std::string> name_of;
  unsigned index = 0;
  for (const pugi::xml_node v : root.child("ModelVariables")) {
    ++index;
    EXPECT_STREQ(v.name(), "ScalarVariable");
    const std::string name = v.attribute("name").value(),
                      causality = v.attribute("causality").value(),
                      variability = v.attribute("variability").value(),
                      initial = v.attribute("initial").value();
    SCOPED_TRACE(name);
    EXPECT_TRUE(names.insert(name).second);
    EXPECT_TRUE(references.insert(v.attribute("valueReference").as_uint()).second);
    EXPECT_EQ(v.attribute("valueReference").as_uint(), fmu_tests::reference_of(name));
    const pugi::xml_node typed = *v.begin();
    const std::string type = typed.name();
    if (type == "Real") {
      EXPECT_TRUE(units.contains(typed.attribute("unit").value()));
    }
    if (type != "Real") {
      EXPECT_NE(variability, "continuous");
    }
    // The table of combinations in section 2.2.7 of the standard.
    const bool has_start = typed.attribute("start");
    EXPECT_EQ(has_start, causality == "input" || causality == "parameter");
    if (causality == "parameter") {
      EXPECT_TRUE(variability == "fixed" || variability == "tunable");
      EXPECT_EQ(initial, "exact");
    } else if (causality == "output" || causality == "local") {
      EXPECT_EQ(initial, "calculated");
    } else {
      EXPECT_EQ(initial, "");
    }
    if (causality == "independent") {
      EXPECT_EQ(variability, "continuous");
    }
    expect_bounds(typed);
    name_of[index] = name;
    if (causality == "output") outputs.push_back(index);
    if (typed.attribute("derivative")) {
      rates.push_back(index);
      state_of[index] = typed.attribute("derivative").as_uint();
    }
    if (causality == "output" || name.starts_with("state.") || name.starts_with("der("))
      unknowns.push_back(index);
  }
  EXPECT_EQ(rates.size(), vehicle::kStateSize);
  for (const auto& [rate, state] : state_of)
    EXPECT_EQ(name_of[rate], "der(" + name_of[state] + ")");
  EXPECT_TRUE(root.child("CoSimulation").attribute("providesDirectionalDerivative").as_bool());
  EXPECT_EQ(index, fmu::count_values(fmu::variables()));
  const pugi::xml_node structure = root.child("ModelStructure");
  expect_order(structure, {"Outputs", "Derivatives", "InitialUnknowns"});
  for (const auto& [list, wanted] :
       {std::pair{"Outputs", &outputs}, {"Derivatives", &rates}, {"InitialUnknowns", &unknowns}}) {
    std::vector<unsigned> listed;
    for (const pugi::xml_node unknown : structure.child(list))
      listed.push_back(unknown.attribute("index").as_uint());
    EXPECT_EQ(listed, *wanted) << list;
  }
  // What an output depends on is a state, never an input.
  std::map<std::string, std::string> behind;
  for (const pugi::xml_node output : structure.child("Outputs")) {
    std::istringstream words(output.attribute("dependencies").value());
    std::string& found = behind[name_of[output.attribute("index").as_uint()]];
    for (unsigned state = 0; words >> state;) {
      EXPECT_TRUE(name_of[state].starts_with("state.")) << name_of[state];
      found += name_of[state] + " ";
    }
  }
  EXPECT_EQ(behind["car.vx"], "state.vx ");
  EXPECT_EQ(behind["car.u"], "state.x state.y ");
  EXPECT_EQ(behind["wheel.rr.spin"], "state.wheel.rr.spin ");
  EXPECT_EQ(behind["wheel.rr.fz"], "");
}

TEST(ModelDescription, OfFmi3KeepsTheRules) {
  const fmu_tests::Unit unit(fmu::Version::kFmi3);
  const pugi::xml_document document = parsed(unit);
  const pugi::xml_node root = document.child("fmiModelDescription");
  EXPECT_STREQ(root.attribute("fmiVersion").value(), "3.0");
  EXPECT_EQ(root.attribute("instantiationToken").value(), unit.token());
  expect_order(root, {"CoSimulation", "UnitDefinitions", "LogCategories", "DefaultExperiment",
                      "ModelVariables", "ModelStructure"});
  EXPECT_TRUE(unit.files().contains(
      std::string("binaries/x86_64-linux/") +
      root.child("CoSimulation").attribute("modelIdentifier").value() + ".so"));
  const std::set<std::string> units = units_of(root);
  std::set<std::string> names;
  std::set<unsigned> references, outputs, rates, begins;
  std::map<unsigned, std::string> name_of;
  unsigned independent = 0, arrays = 0;
  for (const pugi::xml_node v : root.child("ModelVariables")) {
    const std::string type = v.name(), causality = v.attribute("causality").value();
    SCOPED_TRACE(v.attribute("name").value());
    EXPECT_TRUE(type == "Float64" || type == "Int32" || type == "Boolean" || type == "String");
    EXPECT_TRUE(names.insert(v.attribute("name").value()).second);
    EXPECT_TRUE(references.insert(v.attribute("valueReference").as_uint()).second);
    if (type == "Float64") {
      EXPECT_TRUE(units.contains(v.attribute("unit").value()));
    }
    const bool has_start = v.attribute("start") || v.child("Start");
    EXPECT_EQ(has_start, causality == "input" || causality == "parameter");
    expect_bounds(v);
    if (v.child("Dimension")) {
      ++arrays;
      EXPECT_EQ(v.child("Dimension").attribute("start").as_uint(), 4u);
      if (has_start) {
        std::istringstream starts(v.attribute("start").value());
        unsigned count = 0;
        for (std::string word; starts >> word;) ++count;
        EXPECT_EQ(count, 4u);
      }
    }
    const unsigned reference = v.attribute("valueReference").as_uint();
    const std::string name = name_of[reference] = v.attribute("name").value();
    if (causality == "output") outputs.insert(reference);
    if (v.attribute("derivative")) {
      rates.insert(reference);
      EXPECT_EQ(name, "der(" + name_of[v.attribute("derivative").as_uint()] + ")");
    }
    if (causality == "output" || name.starts_with("state.") || name.starts_with("der("))
      begins.insert(reference);
    independent += causality == "independent";
  }
  EXPECT_EQ(independent, 1u);
  EXPECT_GT(arrays, 30u);
  EXPECT_TRUE(root.child("CoSimulation").attribute("providesDirectionalDerivatives").as_bool());
  std::map<std::string, std::set<unsigned>> listed;
  expect_order(root.child("ModelStructure"),
               {"Output", "ContinuousStateDerivative", "InitialUnknown"});
  for (const pugi::xml_node node : root.child("ModelStructure")) {
    EXPECT_TRUE(listed[node.name()].insert(node.attribute("valueReference").as_uint()).second);
    std::istringstream words(node.attribute("dependencies").value());
    for (unsigned state = 0; words >> state;)
      EXPECT_TRUE(name_of[state].starts_with("state.")) << name_of[state];
  }
  EXPECT_EQ(listed["Output"], outputs);
  EXPECT_EQ(listed["ContinuousStateDerivative"], rates);
  EXPECT_EQ(listed["InitialUnknown"], begins);
}

TEST(ModelDescription, WhateverTheCarIsCalledStaysXml) {
  fmu::Description d;
  d.name = "a\"<b>&\x01\xff\xc3\xa4";
  d.starts.assign(fmu::count_values(fmu::variables()), 0.0);
  pugi::xml_document document;
  for (const fmu::Version version : {fmu::Version::kFmi2, fmu::Version::kFmi3}) {
    ASSERT_TRUE(document.load_string(fmu::model_description(d, version).c_str()));
    EXPECT_STREQ(document.child("fmiModelDescription").attribute("modelName").value(),
                 "a\"<b>&??\xc3\xa4");
  }
}

}  // namespace model_description_test
