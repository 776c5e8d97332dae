#include "fmu/model_description.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "fmu/unit_definition.h"

namespace fmu {
namespace {

/// How many bytes of valid UTF-8 begin here; 0: none.
std::size_t character_at(std::string_view text, std::size_t i) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned char first = byte(i);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || i + length > text.size()) return 0;
  for (std::size_t k = 1; k < length; ++k)
    if ((byte(i + k) & 0xc0) != 0x80) return 0;
  // Overlong forms, surrogates and what lies beyond the last character.
  const unsigned char second = byte(i + 1);
  const bool wrong = (first == 0xe0 && second < 0xa0) || (first == 0xed && second > 0x9f) ||
                     (first == 0xf0 && second < 0x90) || (first == 0xf4 && second > 0x8f);
  return wrong ? 0 : length;
}

/// Words for an attribute. What XML cannot hold becomes a question mark.
std::string xml(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = character_at(text, i);
    const char c = text[i];
    if (length == 0 || (length == 1 && (static_cast<unsigned char>(c) < 32 || c == 127)))
      out += '?';
    else if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += text.substr(i, length);
    i += length == 0 ? 1 : length;
  }
  return out;
}

const char* word(Causality causality) {
  switch (causality) {
    case Causality::kIndependent:
      return "independent";
    case Causality::kInput:
      return "input";
    case Causality::kOutput:
      return "output";
    case Causality::kParameter:
      return "parameter";
    case Causality::kLocal:
      break;
  }
  return "local";
}

const char* word(Variability variability) {
  switch (variability) {
    case Variability::kContinuous:
      return "continuous";
    case Variability::kDiscrete:
      return "discrete";
    case Variability::kTunable:
      return "tunable";
    case Variability::kFixed:
      break;
  }
  return "fixed";
}

bool has_start(const Variable& v) {
  return v.causality == Causality::kInput || v.causality == Causality::kParameter;
}

std::string start_word(const Variable& v, double value) {
  if (v.type == Type::kBoolean) return value != 0.0 ? "true" : "false";
  if (v.type == Type::kInteger) return fmt::format("{:.0f}", value);
  return fmt::format("{}", value);
}

std::string bounds(const Variable& v) {
  if (v.type == Type::kBoolean) return {};
  std::string out;
  if (std::isfinite(v.low)) out += fmt::format(" min=\"{}\"", start_word(v, v.low));
  if (std::isfinite(v.high)) out += fmt::format(" max=\"{}\"", start_word(v, v.high));
  return out;
}

std::string unit_definitions(const std::vector<Variable>& list) {
  std::map<std::string, UnitDefinition> units;
  for (const Variable& v : list)
    if (v.type == Type::kReal) units.emplace(v.unit, define_unit(v.unit));
  std::string out = "  <UnitDefinitions>\n";
  for (const auto& [name, unit] : units) {
    out += fmt::format("    <Unit name=\"{}\"><BaseUnit", xml(name));
    const auto add = [&](const char* base, int exponent) {
      if (exponent != 0) out += fmt::format(" {}=\"{}\"", base, exponent);
    };
    add("kg", unit.kg);
    add("m", unit.m);
    add("s", unit.s);
    add("K", unit.K);
    add("rad", unit.rad);
    if (unit.factor != 1.0) out += fmt::format(" factor=\"{}\"", unit.factor);
    out += "/></Unit>\n";
  }
  return out + "  </UnitDefinitions>\n";
}

bool is_unknown_at_the_begin(const Variable& v) {
  return v.causality == Causality::kOutput || v.source == Source::kState ||
         v.source == Source::kRate;
}

constexpr const char* kLogCategories =
    "  <LogCategories>\n"
    "    <Category name=\"logStatusError\" description=\"what could not be done\"/>\n"
    "    <Category name=\"logStatusWarning\" description=\"what was done otherwise\"/>\n"
    "  </LogCategories>\n";

/// Reference of the first state; those of the others follow.
std::uint32_t first_state(const std::vector<Variable>& list) {
  return std::find_if(list.begin(), list.end(),
                      [](const Variable& v) { return v.source == Source::kState; })
      ->reference;
}

/// Of the values themselves, as FMI 2 counts them: from 1.
std::string state_indices(const std::vector<Variable>& list, const Variable& v, std::size_t i) {
  std::string out;
  for (const std::size_t state : states_behind(v, i))
    out += fmt::format("{}{}", out.empty() ? "" : " ", first_state(list) + state + 1);
  return out;
}

/// Of the arrays.
std::string state_references(const std::vector<Variable>& list, const Variable& v) {
  std::string out;
  for (const std::size_t state : states_behind(v, 0))
    out += fmt::format("{}{}", out.empty() ? "" : " ", first_state(list) + state);
  return out;
}

std::string scalar_variable(const Description& d, const Variable& v, std::size_t i,
                            std::uint32_t first_state_reference) {
  std::string out = fmt::format(
      "    <ScalarVariable name=\"{}\" valueReference=\"{}\" description=\"{}\" causality=\"{}\" "
      "variability=\"{}\"",
      xml(value_name(v, i)), v.reference + i, xml(v.text), word(v.causality), word(v.variability));
  if (v.causality == Causality::kOutput || v.causality == Causality::kLocal)
    out += " initial=\"calculated\"";
  if (v.causality == Causality::kParameter) out += " initial=\"exact\"";
  static constexpr const char* kTypes[] = {"Real", "Integer", "Boolean", "String"};
  out += fmt::format("><{}", kTypes[static_cast<std::size_t>(v.type)]);
  if (v.type == Type::kReal) out += fmt::format(" unit=\"{}\"", xml(v.unit));
  if (v.source == Source::kRate)
    out += fmt::format(" derivative=\"{}\"", first_state_reference + v.index + i + 1);
  if (v.type == Type::kString) {
    out += fmt::format(" start=\"{}\"", xml(d.texts[v.index]));
  } else if (has_start(v)) {
    out += bounds(v) + fmt::format(" start=\"{}\"", start_word(v, d.starts[v.reference + i]));
  }
  return out + "/></ScalarVariable>\n";
}

std::string array_variable(const Description& d, const Variable& v,
                           std::uint32_t first_state_reference) {
  static constexpr const char* kTypes[] = {"Float64", "Int32", "Boolean", "String"};
  const char* const type = kTypes[static_cast<std::size_t>(v.type)];
  std::string out = fmt::format(
      "    <{} name=\"{}\" valueReference=\"{}\" description=\"{}\" causality=\"{}\" "
      "variability=\"{}\"",
      type, xml(array_name(v)), v.reference, xml(v.text), word(v.causality), word(v.variability));
  if (v.causality == Causality::kOutput || v.causality == Causality::kLocal)
    out += " initial=\"calculated\"";
  if (v.type == Type::kReal) out += fmt::format(" unit=\"{}\"", xml(v.unit));
  if (v.source == Source::kRate)
    out += fmt::format(" derivative=\"{}\"", first_state_reference + v.index);
  if (v.type == Type::kString)
    return out + fmt::format("><Start value=\"{}\"/></String>\n", xml(d.texts[v.index]));
  if (has_start(v)) {
    std::string starts;
    for (std::size_t i = 0; i < v.size; ++i)
      starts += (i == 0 ? "" : " ") + start_word(v, d.starts[v.reference + i]);
    out += bounds(v) + fmt::format(" start=\"{}\"", starts);
  }
  if (v.size == 1) return out + "/>\n";
  return out + fmt::format("><Dimension start=\"{}\"/></{}>\n", v.size, type);
}

std::string fmi2(const Description& d, const std::vector<Variable>& list) {
  std::string out = fmt::format(
      "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"{}\" guid=\"{}\" "
      "generationTool=\"{}\" variableNamingConvention=\"structured\">\n"
      "  <CoSimulation modelIdentifier=\"{}\" canHandleVariableCommunicationStepSize=\"true\" "
      "canInterpolateInputs=\"false\" maxOutputDerivativeOrder=\"0\" canGetAndSetFMUstate=\"true\" "
      "canSerializeFMUstate=\"true\" providesDirectionalDerivative=\"true\" "
      "canNotUseMemoryManagementFunctions=\"true\"/>\n",
      xml(d.name), xml(d.token), xml(d.generation_tool), kModelIdentifier);
  out += unit_definitions(list) + kLogCategories;
  out += fmt::format("  <DefaultExperiment startTime=\"0\" stopTime=\"10\" stepSize=\"{}\"/>\n",
                     d.step_s);
  out += "  <ModelVariables>\n";
  std::string outputs, rates, unknowns;
  std::size_t index = 0;
  for (const Variable& v : list)
    for (std::size_t i = 0; i < v.size; ++i) {
      ++index;
      out += scalar_variable(d, v, i, first_state(list));
      if (v.causality == Causality::kOutput)
        outputs += fmt::format("      <Unknown index=\"{}\" dependencies=\"{}\"/>\n", index,
                               state_indices(list, v, i));
      if (v.source == Source::kRate) rates += fmt::format("      <Unknown index=\"{}\"/>\n", index);
      if (is_unknown_at_the_begin(v))
        unknowns += fmt::format("      <Unknown index=\"{}\"/>\n", index);
    }
  return out + "  </ModelVariables>\n  <ModelStructure>\n    <Outputs>\n" + outputs +
         "    </Outputs>\n    <Derivatives>\n" + rates +
         "    </Derivatives>\n    <InitialUnknowns>\n" + unknowns +
         "    </InitialUnknowns>\n  </ModelStructure>\n</fmiModelDescription>\n";
}

std::string fmi3(const Description& d, const std::vector<Variable>& list) {
  std::string out = fmt::format(
      "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"{}\" instantiationToken=\"{}\" "
      "generationTool=\"{}\" variableNamingConvention=\"structured\">\n"
      "  <CoSimulation modelIdentifier=\"{}\" canGetAndSetFMUState=\"true\" "
      "canSerializeFMUState=\"true\" providesDirectionalDerivatives=\"true\" "
      "canHandleVariableCommunicationStepSize=\"true\" "
      "fixedInternalStepSize=\"{}\"/>\n",
      xml(d.name), xml(d.token), xml(d.generation_tool), kModelIdentifier, d.step_s);
  out += unit_definitions(list) + kLogCategories;
  out += fmt::format("  <DefaultExperiment startTime=\"0\" stopTime=\"10\" stepSize=\"{}\"/>\n",
                     d.step_s);
  out += "  <ModelVariables>\n";
  std::string outputs, rates, unknowns;
  for (const Variable& v : list) {
    out += array_variable(d, v, first_state(list));
    if (v.causality == Causality::kOutput)
      outputs += fmt::format("    <Output valueReference=\"{}\" dependencies=\"{}\"/>\n",
                             v.reference, state_references(list, v));
    if (v.source == Source::kRate)
      rates += fmt::format("    <ContinuousStateDerivative valueReference=\"{}\"/>\n", v.reference);
    if (is_unknown_at_the_begin(v))
      unknowns += fmt::format("    <InitialUnknown valueReference=\"{}\"/>\n", v.reference);
  }
  return out + "  </ModelVariables>\n  <ModelStructure>\n" + outputs + rates + unknowns +
         "  </ModelStructure>\n</fmiModelDescription>\n";
}

}  // namespace

std::string model_description(const Description& description, Version version) {
  const std::vector<Variable> list = variables();
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n" +
         (version == Version::kFmi2 ? fmi2(description, list) : fmi3(description, list));
}

}  // namespace fmu
