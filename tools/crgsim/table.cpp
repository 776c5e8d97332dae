#include <fmt/format.h>

#include "commands.h"

namespace crgsim {

std::pair<std::string, std::string> assignment(const std::string& option, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw command::UsageError(option + " " + text + ": NAME=VALUE wanted");
  return {text.substr(0, equals), text.substr(equals + 1)};
}

std::string csv_of(const std::vector<std::string>& columns, const std::vector<double>& values) {
  std::string text;
  for (const std::string& name : columns) {
    if (!text.empty()) text += ',';
    text += name.find(',') == std::string::npos ? name : '"' + name + '"';
  }
  text += '\n';
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t k = i % columns.size();
    // The time is a sum of steps: 12 digits name the step that is meant.
    text += k == 0 ? fmt::format("{:.12g}", values[i]) : fmt::format("{}", values[i]);
    text += k + 1 < columns.size() ? ',' : '\n';
  }
  return text;
}

}  // namespace crgsim
