#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/one_line.h"
#include "commands.h"
#include "sim/unit_description.h"
#include "sim/unpack.h"

namespace crgsim {
namespace {

constexpr std::array kTypeNames{"float64", "float32", "int8",   "uint8", "int16",
                                "uint16",  "int32",   "uint32", "int64", "uint64",
                                "boolean", "string",  "other"};

const char* name_of(sim::ValueType type) { return kTypeNames.at(static_cast<std::size_t>(type)); }

std::string shown(const std::optional<double>& value) {
  return value ? fmt::format("{:g} s", *value) : "not said";
}

}  // namespace

int info(const InfoCommand& command, Terminal& terminal) {
  const sim::UnitDescription unit =
      sim::read_unit_description(sim::model_description_of(command.unit_path), command.unit_path);
  if (terminal.json) {
    nlohmann::ordered_json variables = nlohmann::ordered_json::array();
    for (const sim::UnitVariable& v : unit.variables)
      variables.push_back({{"name", v.name},
                           {"type", name_of(v.type)},
                           {"values", v.size},
                           {"causality", v.causality},
                           {"variability", v.variability},
                           {"unit", v.unit},
                           {"start", v.start},
                           {"description", v.description}});
    nlohmann::ordered_json json{{"model", unit.model_name},
                                {"fmi", unit.version},
                                {"tool", unit.generation_tool},
                                {"needs_its_tool", unit.needs_its_tool},
                                {"takes_any_step", unit.takes_any_step}};
    for (const auto& [name, value] :
         {std::pair{"start_s", unit.start_s}, {"stop_s", unit.stop_s}, {"step_s", unit.step_s}})
      json[name] = value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
    json["variables"] = std::move(variables);
    terminal.print(base::json_text(json));
    return kOk;
  }
  terminal.print(fmt::format(
      "{}: FMI {}, by {}\nfrom {} to {}, step {}{}\n", base::visible(unit.model_name), unit.version,
      unit.generation_tool.empty() ? "an unnamed tool" : base::visible(unit.generation_tool),
      shown(unit.start_s), shown(unit.stop_s), shown(unit.step_s),
      unit.needs_its_tool ? "; needs the tool that made it" : ""));
  for (const char* const causality : {"input", "output", "parameter", "structuralParameter",
                                      "calculatedParameter", "independent", "local"})
    for (const sim::UnitVariable& v : unit.variables) {
      if (v.causality != causality) continue;
      std::string line = fmt::format(
          "{:<10} {:<40} {:<8}", v.causality.substr(0, 10),
          v.size == 1 ? v.name : fmt::format("{}[1..{}]", v.name, v.size), name_of(v.type));
      if (!v.unit.empty()) line += " " + v.unit;
      if (!v.start.empty()) line += " = " + v.start.substr(0, 40);
      terminal.print(base::visible(line) + "\n");
    }
  return kOk;
}

}  // namespace crgsim
