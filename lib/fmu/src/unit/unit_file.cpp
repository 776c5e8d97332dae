#include "fmu/unit_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "base/text_lines.h"

namespace fmu {

std::string format_unit_file(const UnitFile& unit) {
  const std::vector<Variable> list = variables();
  std::string out = fmt::format("token = {}\n", unit.token);
  for (const Variable& v : list)
    if (v.source == Source::kText) out += fmt::format("{} = {}\n", v.name, unit.texts[v.index]);
  for (const UnitFile::Number& number : unit.numbers)
    out += fmt::format("{} = {}\n", number.name, number.value);
  return out;
}

UnitFile parse_unit_file(std::string_view bytes, const std::string& path,
                         const std::vector<Variable>& list) {
  UnitFile out;
  base::Lines lines(bytes);
  for (std::string_view line; lines.next(line);) {
    const auto refuse = [&](std::string_view why) {
      throw base::Error(fmt::format("{}:{}: {}", path, lines.number(), why));
    };
    if (base::trimmed(line).empty()) continue;
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) refuse("wanted name = value");
    const std::string name(base::trimmed(line.substr(0, equals)));
    const std::string_view value = base::trimmed(line.substr(equals + 1));
    if (name == "token") {
      out.token = value;
      continue;
    }
    const auto found = std::find_if(
        list.begin(), list.end(), [&](const Variable& v) { return v.name == name && v.size == 1; });
    if (found == list.end() || found->causality != Causality::kParameter)
      refuse(fmt::format("there is no parameter '{}'", name.substr(0, 60)));
    if (found->source == Source::kText) {
      out.texts[found->index] = value;
      continue;
    }
    const std::optional<double> number = base::to_number<double>(value);
    if (!number || !(*number >= found->low && *number <= found->high))
      refuse(fmt::format("{} = '{}', wanted {} to {}", name, value.substr(0, 40), found->low,
                         found->high));
    out.numbers.push_back({name, *number});
  }
  if (out.token.empty()) throw base::Error(path + ": no token; this is no unit of crgdrive");
  return out;
}

}  // namespace fmu
