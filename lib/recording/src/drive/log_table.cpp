#include "recording/log_table.h"

#include <fmt/format.h>

#include <unordered_set>
#include <utility>

#include "recording/log.h"

namespace recording {
namespace {

/// One column per channel; its name says the unit, as columns of CSV do.
Table table_of(Log log, const std::string& name, std::vector<std::size_t>* words) {
  log = in_rows(std::move(log), name);
  Table table;
  std::unordered_set<std::string> taken;
  if (words != nullptr) words->clear();
  for (Channel& channel : log.channels) {
    std::string column =
        channel.unit.empty() ? channel.name : fmt::format("{} [{}]", channel.name, channel.unit);
    while (!taken.insert(column).second) column += '\'';
    if (words != nullptr) words->push_back(channel.words);
    table.add(std::move(column), std::move(channel.values));
  }
  return table;
}

}  // namespace

Table parse_log_table(const std::string& text, const std::string& name,
                      std::vector<std::size_t>* words) {
  return table_of(parse_log(text, name), name, words);
}

Table read_log_table(const std::string& path, std::vector<std::size_t>* words,
                     std::vector<std::string>* notes) {
  Log log = read_log(path);
  if (notes != nullptr) *notes = log.notes;
  return table_of(std::move(log), path, words);
}

}  // namespace recording
