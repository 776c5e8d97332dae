#include "sim/unit_description.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <pugixml.hpp>
#include <set>
#include <sstream>

#include "base/error.h"
#include "base/one_line.h"

namespace sim {
namespace {

constexpr std::size_t kMostVariables = 1'000'000, kMostUnitValues = 1'000'000;

struct Reader {
  const std::string& where;

  [[noreturn]] void refuse(const std::string& what) const {
    throw base::Error(where + ": " + base::visible(what));
  }

  template <class Number>
  Number number(const std::string& text, const std::string& of) const {
    Number value{};
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || stop != end)
      refuse(fmt::format("{} is '{}'; a number wanted", of, text.substr(0, 40)));
    return value;
  }

  std::optional<double> time(const pugi::xml_node& experiment, const char* name) const {
    const std::string text = experiment.attribute(name).as_string();
    if (text.empty()) return std::nullopt;
    const double value = number<double>(text, name);
    if (!(value >= -1e12 && value <= 1e12)) refuse(fmt::format("{} is {}", name, text));
    return value;
  }
};

const std::map<std::string, ValueType> kTypes{
    {"Real", ValueType::float64},      {"Integer", ValueType::int32},
    {"Boolean", ValueType::boolean},   {"String", ValueType::string},
    {"Float64", ValueType::float64},   {"Float32", ValueType::float32},
    {"Int8", ValueType::int8},         {"UInt8", ValueType::uint8},
    {"Int16", ValueType::int16},       {"UInt16", ValueType::uint16},
    {"Int32", ValueType::int32},       {"UInt32", ValueType::uint32},
    {"Int64", ValueType::int64},       {"UInt64", ValueType::uint64},
    {"Enumeration", ValueType::int64}, {"Binary", ValueType::other},
    {"Clock", ValueType::other}};

/// Types that variables may name, each with the element that holds its bounds.
using Declared = std::map<std::string, pugi::xml_node>;

Declared declared_types(const pugi::xml_node& root, int version) {
  Declared out;
  for (const pugi::xml_node& type : root.child("TypeDefinitions").children())
    out.emplace(type.attribute("name").as_string(), version == 2 ? type.first_child() : type);
  return out;
}

/// A bound that is no number, or a pair that holds nothing, bounds nothing.
void read_bounds(const pugi::xml_node& node, const Declared& types, UnitVariable& variable) {
  const auto bound = [&](const char* name, double none) {
    pugi::xml_attribute said = node.attribute(name);
    const auto type = types.find(node.attribute("declaredType").as_string());
    if (!said && type != types.end()) said = type->second.attribute(name);
    const std::string_view text = said.as_string();
    double value = none;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() && !std::isnan(value) ? value
                                                                                          : none;
  };
  const double low = bound("min", variable.low), high = bound("max", variable.high);
  if (low > high) return;
  variable.low = low;
  variable.high = high;
}

/// An array's starts have blanks between.
void want_numbers(const Reader& reader, const UnitVariable& variable) {
  if (variable.type == ValueType::string || variable.type == ValueType::other) return;
  std::istringstream words(variable.start);
  for (std::string word; words >> word;) {
    if (word == "true" || word == "false") continue;
    const std::size_t begin = word.starts_with('+') ? 1 : 0;
    double value = 0.0;
    const char* const end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data() + begin, end, value);
    if (error == std::errc::invalid_argument || stop != end)
      reader.refuse(fmt::format("the start of {} is '{}'; a number wanted", variable.name,
                                variable.start.substr(0, 40)));
  }
}

UnitVariable named(const Reader& reader, const pugi::xml_node& node) {
  UnitVariable variable;
  variable.name = node.attribute("name").as_string();
  if (variable.name.empty()) reader.refuse("a variable without a name");
  if (base::visible(variable.name) != variable.name)
    reader.refuse(fmt::format("a variable is called '{}'; a name without control characters wanted",
                              variable.name.substr(0, 60)));
  variable.description = node.attribute("description").as_string();
  variable.causality = node.attribute("causality").as_string("local");
  variable.reference = reader.number<std::uint32_t>(node.attribute("valueReference").as_string(),
                                                    "valueReference of " + variable.name);
  return variable;
}

void read_variables_2(const Reader& reader, const pugi::xml_node& list, const Declared& types,
                      UnitDescription& out) {
  for (const pugi::xml_node& node : list.children("ScalarVariable")) {
    UnitVariable variable = named(reader, node);
    const pugi::xml_node type = node.first_child();
    const auto known = kTypes.find(type.name());
    if (known == kTypes.end())
      reader.refuse(fmt::format("{} is of type '{}'", variable.name, type.name()));
    variable.type = type.name() == std::string("Enumeration") ? ValueType::int32 : known->second;
    variable.variability =
        node.attribute("variability")
            .as_string(variable.type == ValueType::float64 ? "continuous" : "discrete");
    variable.unit = type.attribute("unit").as_string();
    variable.start = type.attribute("start").as_string();
    want_numbers(reader, variable);
    read_bounds(type, types, variable);
    out.variables.push_back(std::move(variable));
    if (out.variables.size() > kMostVariables) reader.refuse("more than a million variables");
  }
}

void read_variables_3(const Reader& reader, const pugi::xml_node& list, const Declared& types,
                      UnitDescription& out) {
  std::map<std::string, std::string> start_of_reference;
  for (const pugi::xml_node& node : list.children())
    start_of_reference[node.attribute("valueReference").as_string()] =
        node.attribute("start").as_string();
  for (const pugi::xml_node& node : list.children()) {
    if (node.type() != pugi::node_element) continue;
    const auto known = kTypes.find(node.name());
    if (known == kTypes.end()) reader.refuse(fmt::format("a variable of type '{}'", node.name()));
    UnitVariable variable = named(reader, node);
    variable.type = known->second;
    const bool is_float =
        variable.type == ValueType::float64 || variable.type == ValueType::float32;
    variable.variability =
        node.attribute("variability").as_string(is_float ? "continuous" : "discrete");
    variable.unit = node.attribute("unit").as_string();
    variable.start = node.attribute("start").as_string();
    if (variable.type == ValueType::string)
      variable.start = node.child("Start").attribute("value").as_string();
    want_numbers(reader, variable);
    read_bounds(node, types, variable);
    for (const pugi::xml_node& dimension : node.children("Dimension")) {
      std::string text = dimension.attribute("start").as_string();
      if (text.empty())
        text = start_of_reference[dimension.attribute("valueReference").as_string()];
      const auto count = reader.number<std::size_t>(text, "a dimension of " + variable.name);
      if (count > kMostUnitValues || variable.size * count > kMostUnitValues)
        reader.refuse(variable.name + " has more than a million values");
      variable.size *= count;
    }
    out.variables.push_back(std::move(variable));
    if (out.variables.size() > kMostVariables) reader.refuse("more than a million variables");
  }
}

}  // namespace

const UnitVariable* UnitDescription::find(std::string_view name) const {
  for (const UnitVariable& variable : variables)
    if (variable.name == name) return &variable;
  return nullptr;
}

UnitDescription read_unit_description(std::string_view xml, const std::string& where) {
  const Reader reader{where};
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(xml.data(), xml.size());
  if (!parsed)
    reader.refuse(fmt::format("no XML: {} at byte {}", parsed.description(), parsed.offset));
  const pugi::xml_node root = document.child("fmiModelDescription");
  if (!root) reader.refuse("no model description: the element fmiModelDescription is missing");
  const std::string version = root.attribute("fmiVersion").as_string();
  UnitDescription out;
  if (version == "2.0")
    out.version = 2;
  else if (version.starts_with("3."))
    out.version = 3;
  else
    reader.refuse(fmt::format("FMI version '{}'; 2.0 or 3 wanted", version));
  out.model_name = root.attribute("modelName").as_string();
  out.token = root.attribute(out.version == 2 ? "guid" : "instantiationToken").as_string();
  out.generation_tool = root.attribute("generationTool").as_string();
  const pugi::xml_node simulation = root.child("CoSimulation");
  if (!simulation)
    reader.refuse("no co-simulation in this unit; export it for co-simulation (CoSimulation)");
  out.identifier = simulation.attribute("modelIdentifier").as_string();
  const bool plain = !out.identifier.empty() && out.identifier.size() <= 200 &&
                     std::all_of(out.identifier.begin(), out.identifier.end(), [](char c) {
                       return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                              (c >= '0' && c <= '9') || c == '_';
                     });
  if (!plain)
    reader.refuse(fmt::format("modelIdentifier is '{}'; letters, digits and _ wanted",
                              out.identifier.substr(0, 60)));
  out.needs_its_tool = simulation.attribute("needsExecutionTool").as_bool();
  out.can_be_instantiated_once_only =
      simulation.attribute("canBeInstantiatedOnlyOncePerProcess").as_bool();
  out.takes_any_step = simulation.attribute("canHandleVariableCommunicationStepSize").as_bool();
  out.keeps_states =
      simulation.attribute(out.version == 2 ? "canGetAndSetFMUstate" : "canGetAndSetFMUState")
          .as_bool();
  const pugi::xml_node experiment = root.child("DefaultExperiment");
  out.start_s = reader.time(experiment, "startTime");
  out.stop_s = reader.time(experiment, "stopTime");
  out.step_s = reader.time(experiment, "stepSize");
  out.tolerance = reader.time(experiment, "tolerance");
  if (out.tolerance && !(*out.tolerance > 0.0)) out.tolerance.reset();
  if (out.step_s && !(*out.step_s > 0.0)) out.step_s.reset();
  const Declared types = declared_types(root, out.version);
  if (out.version == 2)
    read_variables_2(reader, root.child("ModelVariables"), types, out);
  else
    read_variables_3(reader, root.child("ModelVariables"), types, out);
  std::set<std::string_view> names;
  for (const UnitVariable& variable : out.variables)
    if (!names.insert(variable.name).second)
      reader.refuse(fmt::format("two variables are called '{}'", variable.name.substr(0, 60)));
  return out;
}

}  // namespace sim
