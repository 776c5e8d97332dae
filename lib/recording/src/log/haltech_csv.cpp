#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/table_form.h"
#include "base/text_lines.h"
#include "iso_time.h"
#include "readers.h"

namespace recording {
namespace {

/// What a whole number of a channel's type is worth, and of what.
struct Type {
  std::string_view name;
  double scale;
  const char* unit;
  double zero = 0.0;
};
constexpr Type kTypes[] = {{"Angle", 0.1, "deg"},
                           {"Pressure", 0.1, "kPa"},
                           {"AbsPressure", 0.1, "kPa"},
                           {"EngineSpeed", 1.0, "rpm"},
                           {"Percentage", 0.1, "%"},
                           {"Temperature", 0.1, "C", -273.15},
                           {"BatteryVoltage", 1e-3, "V"},
                           {"Time_us", 1e-3, "ms"},
                           {"Time_ms_as_s", 1e-3, "s"},
                           {"AFR", 1e-3, "lambda"},
                           {"Speed", 0.1, "km/h"},
                           {"Acceleration", 1e-3, "g"},
                           {"ShorterDistance", 1e-3, "mm"},
                           {"DrivenDistance", 1e-3, "km"},
                           {"Ratio", 1e-3, "1"},
                           {"AngularVelocity", 0.1, "deg/s"},
                           {"Gear", 1.0, ""},
                           {"Position", 1.0, ""},
                           {"Flow", 1.0, ""},
                           {"Raw", 1.0, ""}};

constexpr std::string_view kBegin = "%DataLog%";

}  // namespace

bool is_haltech_csv(std::string_view text) { return base::trimmed(text).starts_with(kBegin); }

Log parse_haltech_csv(std::string_view text, const std::string& name) {
  std::vector<std::string_view> names, types, cells;
  base::Lines lines(text);
  std::string_view line;
  std::size_t rows_begin = text.size();
  while (lines.next(line)) {
    base::split_cells(line, ',', cells);
    if (!names.empty() && time_of_day(cells.front())) {
      rows_begin = static_cast<std::size_t>(line.data() - text.data());
      break;
    }
    const std::size_t colon = line.find(" : ");
    if (colon == std::string_view::npos) continue;
    const std::string_view key = base::trimmed(line.substr(0, colon)),
                           value = base::trimmed(line.substr(colon + 3));
    if (key == "Channel") names.push_back(value), types.emplace_back();
    if (key == "Type" && !types.empty()) types.back() = value;
  }
  if (rows_begin == text.size())
    throw base::Error(fmt::format(
        "{}: a log of Haltech with {} channels and no row; export it again", name, names.size()));
  // The same rows below one line of names, in the line that they have in the file.
  std::string table(lines.number() - 2, '\n');
  table += "Time";
  for (const std::string_view channel : names) {
    table += ",\"";
    table += channel;
    table += '"';
  }
  table += '\n';
  table += text.substr(rows_begin);
  Log log = parse_csv(table, name);
  log.format = "CSV of Haltech";
  for (std::size_t c = 0; c < types.size(); ++c) {
    Channel& channel = log.channels.at(c + 1);
    const Type* const type =
        std::find_if(std::begin(kTypes), std::end(kTypes),
                     [&](const Type& known) { return known.name == types[c]; });
    if (type == std::end(kTypes)) {
      log.notes.push_back(
          fmt::format("'{}': its type '{:.40}' is not known; its numbers are as they stand",
                      channel.name, types[c]));
      continue;
    }
    channel.unit = type->unit;
    for (double& value : channel.values) value = value * type->scale + type->zero;
  }
  return log;
}

}  // namespace recording
