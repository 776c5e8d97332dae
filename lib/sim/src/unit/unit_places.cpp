#include "unit_places.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <sstream>
#include <vector>

#include "base/error.h"

namespace sim {
namespace {

double number(const std::string& path, const std::string& name, const std::string& text) {
  if (text == "true" || text == "false") return text == "true" ? 1.0 : 0.0;
  double value = 0.0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size())
    throw base::Error(fmt::format("{}: '{}' for {}; a number wanted", path, text, name));
  return value;
}

}  // namespace

bool is_number(const UnitVariable& variable) {
  return variable.type != ValueType::string && variable.type != ValueType::other;
}

bool is_settable(const UnitVariable& variable) {
  return variable.is_input() ||
         (variable.causality == "parameter" && variable.variability == "tunable");
}

std::string wrong_with(const UnitVariable& variable, double value) {
  const bool is_float = variable.type == ValueType::float64 || variable.type == ValueType::float32;
  const bool is_bounded = std::isfinite(variable.low) || std::isfinite(variable.high);
  const std::string range =
      is_bounded ? fmt::format(" from {} to {}", variable.low, variable.high) : "";
  const auto wanted = [&](const std::string& what) {
    return fmt::format("{} = {}; {} wanted", variable.name, value, what);
  };
  if (variable.type == ValueType::boolean && value != 0.0 && value != 1.0) return wanted("0 or 1");
  if (!is_float && value != std::round(value)) return wanted("a whole number" + range);
  if (!(value >= variable.low && value <= variable.high)) return wanted("a number" + range);
  return {};
}

std::string not_finite_of(const std::vector<std::string>& names, const std::vector<double>& values,
                          double time_s) {
  for (std::size_t k = 0; k < values.size(); ++k)
    if (!std::isfinite(values[k]))
      return fmt::format("{} is {} at {:g} s", names[k], values[k], time_s);
  return {};
}

const UnitVariable& known(const UnitDescription& unit, const std::string& path,
                          const std::string& name) {
  if (const UnitVariable* const found = unit.find(name)) return *found;
  throw base::Error(fmt::format("{}: no variable '{}'; crgsim info lists them", path, name));
}

Place place_of(const UnitDescription& unit, const std::string& path, const std::string& name) {
  if (const UnitVariable* const whole = unit.find(name)) {
    if (whole->size != 1)
      throw base::Error(fmt::format("{}: {} has {} values; name them one by one, {}[1] to {}[{}]",
                                    path, name, whole->size, name, name, whole->size));
    return {whole, 0};
  }
  const std::size_t bracket = name.rfind('[');
  if (bracket != std::string::npos && name.ends_with(']')) {
    const UnitVariable& variable = known(unit, path, name.substr(0, bracket));
    std::size_t index = 0;
    const char* const end = name.data() + name.size() - 1;
    const auto [stop, error] = std::from_chars(name.data() + bracket + 1, end, index);
    if (error == std::errc() && stop == end && index >= 1 && index <= variable.size)
      return {&variable, index - 1};
  }
  return {&known(unit, path, name), 0};
}

std::string road_of(const std::vector<std::pair<std::string, std::string>>& starts) {
  std::string road;
  for (const auto& [name, text] : starts)
    if (name == "road") road = text;
  return road;
}

void set_start(Unit& unit, const std::string& path, const std::string& name,
               const std::string& text) {
  const UnitVariable& variable = known(unit.description(), path, name);
  if (variable.type == ValueType::string) return unit.set_text(variable, text);
  std::vector<double> values;
  std::istringstream words(text);
  for (std::string word; words >> word;) values.push_back(number(path, name, word));
  unit.set(variable, values);
}

}  // namespace sim
