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
#include "recording/look.h"
#include "vehicle/error.h"

namespace crgexplain {
namespace {

/// What the mapping makes of a channel; empty: nothing.
std::string becomes(const recording::ChannelLook& look, const explain::Mapping& mapping) {
  const std::string column =
      look.unit.empty() ? look.name : fmt::format("{} [{}]", look.name, look.unit);
  std::string out;
  for (const explain::ColumnMapping& m : mapping.columns)
    if (m.column == column) out += (out.empty() ? "" : ", ") + m.channel;
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
  std::vector<recording::ChannelLook> listed;
  if (command.list || terminal.json)
    listed = recording::look_at_channels(recording::read_log(command.log_path));
  if (terminal.json) {
    nlohmann::ordered_json columns = nlohmann::ordered_json::object();
    for (const explain::ColumnMapping& m : mapping.columns)
      if (columns.contains(m.column))  // the pressure of an axle
        columns[m.column] = {columns[m.column], m.channel};
      else
        columns[m.column] = m.channel;
    nlohmann::ordered_json channels = nlohmann::ordered_json::array();
    for (const recording::ChannelLook& c : listed)
      channels.push_back({{"name", c.name},
                          {"unit", c.unit},
                          {"rate_hz", c.rate_hz},
                          {"samples", c.samples},
                          {"least", c.least},
                          {"greatest", c.greatest},
                          {"channel", becomes(c, mapping)}});
    terminal.print(base::json_text(nlohmann::ordered_json{{"rows", table.rows()},
                                                          {"columns", table.names.size()},
                                                          {"channel_of_column", columns},
                                                          {"notes", notes},
                                                          {"missing", mapping.missing},
                                                          {"channels", channels},
                                                          {"mapping", command.out_path}}));
    return mapping.missing.empty() ? kOk : command::kNotValid;
  }
  std::set<std::string> used;
  for (const explain::ColumnMapping& m : mapping.columns) used.insert(m.column);
  terminal.print(fmt::format("{} rows, {} of {} columns used\n", table.rows(), used.size(),
                             table.names.size()));
  if (command.list) {
    terminal.print(fmt::format("{:<32} {:<10} {:>9} {:>9} {:>12} {:>12}  {}\n", "channel", "unit",
                               "rate, Hz", "samples", "least", "greatest", "becomes"));
    for (const recording::ChannelLook& c : listed)
      terminal.print(fmt::format(
          "{:<32} {:<10} {:>9} {:>9} {:>12.6g} {:>12.6g}  {}\n", one_line(c.name), one_line(c.unit),
          c.rate_hz > 0 ? fmt::format("{:.4g}", c.rate_hz) : "?", c.samples, c.least, c.greatest,
          becomes(c, mapping).empty() ? "-" : becomes(c, mapping)));
  }
  for (const std::string& note : notes) terminal.print(fmt::format("  {}\n", one_line(note)));
  for (const std::string& missing : mapping.missing)
    terminal.print(fmt::format("  {}\n", one_line(missing)));
  terminal.print(fmt::format("{}: {}\n", command.out_path,
                             mapping.missing.empty()
                                 ? "look through it and correct what was guessed wrong"
                                 : "a draft that no command can use yet"));
  return mapping.missing.empty() ? kOk : command::kNotValid;
}

}  // namespace crgexplain
