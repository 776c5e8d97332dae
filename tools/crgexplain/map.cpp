#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "explain/mapping.h"
#include "base/json_text.h"
#include "base/write_file.h"
#include "vehicle/error.h"

namespace crgexplain {

int map(const MapCommand& command, Terminal& terminal) {
  std::error_code none;
  if (std::filesystem::equivalent(command.log_path, command.out_path, none))
    throw vehicle::Error(fmt::format("{}: is the log, and -o would overwrite it; choose another name", command.out_path));
  std::vector<std::size_t> words;
  const vehicle::Table table = vehicle::read_log(command.log_path, &words);
  const explain::Mapping mapping = explain::propose_mapping(table, command.log_path);
  std::vector<std::string> notes = mapping.notes;
  for (std::size_t c = 0; c < words.size(); ++c)
    if (words[c] > 0) notes.push_back(fmt::format("{} of {} cells of '{}' are no numbers: taken as empty", words[c], table.rows(), table.names[c]));
  base::write_file(command.out_path, explain::format_mapping(mapping));
  if (terminal.json) {
    nlohmann::ordered_json columns = nlohmann::ordered_json::object();
    for (const explain::ColumnMapping& m : mapping.columns) columns[m.column] = m.channel;
    terminal.print(base::json_text(nlohmann::ordered_json{{"rows", table.rows()},
                                                           {"columns", table.names.size()},
                                                           {"channel_of_column", columns},
                                                           {"notes", notes},
                                                           {"mapping", command.out_path}}));
    return kOk;
  }
  terminal.print(fmt::format("{} rows, {} of {} columns used\n", table.rows(), mapping.columns.size(), table.names.size()));
  for (const std::string& note : notes) terminal.print(fmt::format("  {}\n", one_line(note)));
  terminal.print(fmt::format("{}: look through it and correct what was guessed wrong\n", command.out_path));
  return kOk;
}

}  // namespace crgexplain
