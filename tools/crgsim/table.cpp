#include <fmt/format.h>

#include <filesystem>
#include <iterator>
#include <utility>

#include "commands.h"

namespace crgsim {

std::pair<std::string, std::string> assignment(const std::string& option, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw command::UsageError(option + " " + text + ": NAME=VALUE wanted");
  return {text.substr(0, equals), text.substr(equals + 1)};
}

namespace {

std::string header_of(const std::vector<std::string>& columns) {
  std::string text;
  for (const std::string& name : columns) {
    if (!text.empty()) text += ',';
    text += name.find(',') == std::string::npos ? name : '"' + name + '"';
  }
  return text + '\n';
}

}  // namespace

sim::KeepRow rows_into(base::GrowingFile& file) {
  return [&file, is_first = true](const std::vector<std::string>& columns,
                                  std::span<const double> row) mutable {
    if (std::exchange(is_first, false)) file.append(header_of(columns));
    // The time is a sum of steps: 12 digits name the step that is meant.
    std::string text = fmt::format("{:.12g}", row[0]);
    for (const double value : row.subspan(1))
      fmt::format_to(std::back_inserter(text), ",{}", value);
    file.append(text + '\n');
  };
}

std::function<void(std::string_view)> lines_into(base::GrowingFile& file) {
  return [&file](std::string_view line) { file.append(std::string(line) + '\n'); };
}

std::string remarks_path(const std::string& record_path) {
  return std::filesystem::path(record_path).replace_extension(".remarks.jsonl").string();
}

void say_killed(const base::GrowingFile& file, Terminal& terminal) {
  if (!file.killed().empty())
    terminal.remark(file.killed() + ": what a run had written here that was killed");
}

}  // namespace crgsim
