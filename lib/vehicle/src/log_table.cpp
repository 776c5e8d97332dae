#include "vehicle/log_table.h"

#include <fmt/format.h>

#include <utility>

#include "recording/log.h"

namespace vehicle {
namespace {

/// One column per channel; its name says the unit, as columns of CSV do.
Table table_of(recording::Log log, const std::string& name, std::vector<std::size_t>* words) {
  log = recording::in_rows(std::move(log), name);
  Table table;
  if (words != nullptr) words->clear();
  for (recording::Channel& channel : log.channels) {
    std::string column =
        channel.unit.empty() ? channel.name : fmt::format("{} [{}]", channel.name, channel.unit);
    while (table.find(column) != nullptr) column += '\'';
    if (words != nullptr) words->push_back(channel.words);
    table.add(std::move(column), std::move(channel.values));
  }
  return table;
}

}  // namespace

Table parse_log(const std::string& text, const std::string& name, std::vector<std::size_t>* words) {
  return table_of(recording::parse_log(text, name), name, words);
}

Table read_log(const std::string& path, std::vector<std::size_t>* words,
               std::vector<std::string>* notes) {
  recording::Log log = recording::read_log(path);
  if (notes != nullptr) *notes = log.notes;
  return table_of(std::move(log), path, words);
}

}  // namespace vehicle
