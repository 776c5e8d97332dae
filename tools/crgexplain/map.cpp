#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "base/json_text.h"
#include "base/write_file.h"
#include "commands.h"
#include "explain/mapping.h"
#include "recording/log.h"
#include "recording/log_table.h"
#include "vehicle/error.h"

namespace crgexplain {
namespace {

/// A channel as logged and what the mapping makes of it.
struct Listed {
  std::string name, unit, canonical;
  double rate_hz = 0.0;     ///< 0: the file has no clock that tells
  std::size_t samples = 0;  ///< that are numbers
  double least = 0.0, greatest = 0.0;
};

std::vector<Listed> channels_of(const std::string& path, const explain::Mapping& mapping) {
  std::vector<Listed> out;
  for (const recording::Channel& channel : recording::read_log(path).channels) {
    Listed listed{channel.name, channel.unit, "", channel.rate_hz, 0, 0.0, 0.0};
    const std::string column =
        channel.unit.empty() ? channel.name : fmt::format("{} [{}]", channel.name, channel.unit);
    for (const explain::ColumnMapping& m : mapping.columns)
      if (m.column == column)
        listed.canonical += (listed.canonical.empty() ? "" : ", ") + m.channel;
    for (const double value : channel.values) {
      if (!std::isfinite(value)) continue;
      listed.least = listed.samples == 0 ? value : std::min(listed.least, value);
      listed.greatest = listed.samples == 0 ? value : std::max(listed.greatest, value);
      ++listed.samples;
    }
    out.push_back(std::move(listed));
  }
  return out;
}

}  // namespace

int map(const MapCommand& command, Terminal& terminal) {
  std::error_code none;
  if (std::filesystem::equivalent(command.log_path, command.out_path, none))
    throw vehicle::Error(fmt::format(
        "{}: is the log, and -o would overwrite it; choose another name", command.out_path));
  std::vector<std::size_t> words;
  std::vector<std::string> not_read;
  const recording::Table table = recording::read_log_table(command.log_path, &words, &not_read);
  const explain::Mapping mapping = explain::propose_mapping(table, command.log_path);
  for (const explain::ColumnMapping& m : mapping.columns) {
    const auto at = std::find(table.names.begin(), table.names.end(), m.column);
    const auto c = static_cast<std::size_t>(at - table.names.begin());
    if (m.channel == "time_s" && c < words.size() && words[c] > 0 && words[c] == table.rows())
      throw vehicle::Error(fmt::format(
          "{}: the clock, column '{}', holds no number in any of its {} rows; write seconds, or "
          "dates with times as 2024-05-01T12:00:00.1Z",
          command.log_path, m.column, table.rows()));
  }
  std::vector<std::string> notes = not_read;
  notes.insert(notes.end(), mapping.notes.begin(), mapping.notes.end());
  for (std::size_t c = 0; c < words.size(); ++c)
    if (words[c] > 0)
      notes.push_back(fmt::format("{} of {} cells of '{}' are no numbers: taken as empty", words[c],
                                  table.rows(), table.names[c]));
  base::write_file(command.out_path, explain::format_mapping(mapping));
  const std::vector<Listed> listed = command.list || terminal.json
                                         ? channels_of(command.log_path, mapping)
                                         : std::vector<Listed>{};
  if (terminal.json) {
    nlohmann::ordered_json columns = nlohmann::ordered_json::object();
    for (const explain::ColumnMapping& m : mapping.columns)
      if (columns.contains(m.column))  // the pressure of an axle
        columns[m.column] = {columns[m.column], m.channel};
      else
        columns[m.column] = m.channel;
    nlohmann::ordered_json channels = nlohmann::ordered_json::array();
    for (const Listed& c : listed)
      channels.push_back({{"name", c.name},
                          {"unit", c.unit},
                          {"rate_hz", c.rate_hz},
                          {"samples", c.samples},
                          {"least", c.least},
                          {"greatest", c.greatest},
                          {"channel", c.canonical}});
    terminal.print(base::json_text(nlohmann::ordered_json{{"rows", table.rows()},
                                                          {"columns", table.names.size()},
                                                          {"channel_of_column", columns},
                                                          {"notes", notes},
                                                          {"channels", channels},
                                                          {"mapping", command.out_path}}));
    return kOk;
  }
  std::set<std::string> used;
  for (const explain::ColumnMapping& m : mapping.columns) used.insert(m.column);
  terminal.print(fmt::format("{} rows, {} of {} columns used\n", table.rows(), used.size(),
                             table.names.size()));
  if (command.list) {
    terminal.print(fmt::format("{:<32} {:<10} {:>9} {:>9} {:>12} {:>12}  {}\n", "channel", "unit",
                               "rate, Hz", "samples", "least", "greatest", "becomes"));
    for (const Listed& c : listed)
      terminal.print(fmt::format("{:<32} {:<10} {:>9} {:>9} {:>12.6g} {:>12.6g}  {}\n",
                                 one_line(c.name), one_line(c.unit),
                                 c.rate_hz > 0 ? fmt::format("{:.4g}", c.rate_hz) : "?", c.samples,
                                 c.least, c.greatest, c.canonical.empty() ? "-" : c.canonical));
  }
  for (const std::string& note : notes) terminal.print(fmt::format("  {}\n", one_line(note)));
  terminal.print(
      fmt::format("{}: look through it and correct what was guessed wrong\n", command.out_path));
  return kOk;
}

}  // namespace crgexplain
