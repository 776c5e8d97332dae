#include "vehicle/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>

#include "base/read_file.h"
#include "base/text_lines.h"
#include "settings.h"
#include "vehicle/error.h"

namespace vehicle {
namespace {

constexpr std::size_t kLargestFileBytes = std::size_t{1} << 30;

/// Calls f(cell, index) for every cell and returns their number.
template <class F>
std::size_t for_each_cell(std::string_view line, char separator, F&& f) {
  std::size_t index = 0;
  for (;;) {
    const std::size_t comma = line.find(separator);
    f(base::trimmed(line.substr(0, comma)), index++);
    if (comma == std::string_view::npos) return index;
    line.remove_prefix(comma + 1);
  }
}

/// What sets a log apart from a table: its separator, and what its cells may hold.
struct Reading {
  char separator = ',';
  bool anything = false;  ///< a log
  std::vector<std::size_t>* words = nullptr;
};

Table parse(const std::string& text, const std::string& name, const Reading& reading) {
  Table table;
  std::size_t line_number = 0;
  std::string_view rest = text;
  if (rest.starts_with("\xef\xbb\xbf")) rest.remove_prefix(3);
  std::vector<double> row;
  while (!rest.empty()) {
    const std::size_t end = rest.find('\n');
    const std::string_view whole = rest.substr(0, end);
    // A tab at an end may be an empty cell.
    const std::string_view line = reading.separator == '\t' && !base::trimmed(whole).empty()
                                      ? whole.substr(0, whole.find_last_not_of('\r') + 1)
                                      : base::trimmed(whole);
    const bool cut_off = end == std::string_view::npos;
    rest.remove_prefix(cut_off ? rest.size() : end + 1);
    ++line_number;
    if (line.empty() || line.front() == '#') continue;
    const auto where = [&] { return fmt::format("{}:{}", name, line_number); };
    if (table.names.empty()) {
      for_each_cell(line, reading.separator, [&](std::string_view cell, std::size_t) {
        if (reading.anything && cell.size() >= 2 && cell.front() == '"' && cell.back() == '"')
          cell = cell.substr(1, cell.size() - 2);
        if (cell.empty()) throw Error(where() + ": a column without a name");
        if (std::find(table.names.begin(), table.names.end(), cell) != table.names.end())
          throw Error(fmt::format("{}: column '{}' twice", where(), cell.substr(0, 40)));
        table.names.emplace_back(cell);
      });
      table.columns.resize(table.names.size());
      row.resize(table.names.size());
      if (reading.words != nullptr) reading.words->assign(table.names.size(), 0);
      continue;
    }
    const std::size_t cells =
        for_each_cell(line, reading.separator, [&](std::string_view cell, std::size_t index) {
          if (index >= table.names.size()) return;
          double value = std::numeric_limits<double>::quiet_NaN();
          if (!cell.empty()) {
            std::string_view digits = cell;
            if (digits.front() == '+') digits.remove_prefix(1);
            const auto [stop, error] =
                std::from_chars(digits.data(), digits.data() + digits.size(), value);
            if (error != std::errc() || stop != digits.data() + digits.size() ||
                !std::isfinite(value)) {
              if (!reading.anything)
                throw Error(fmt::format("{}: '{}' in column {}, wanted a finite number or nothing",
                                        where(), cell.substr(0, 40),
                                        table.names[index].substr(0, 40)));
              value = std::numeric_limits<double>::quiet_NaN();
              if (reading.words != nullptr) ++(*reading.words)[index];
            }
          }
          row[index] = value;
        });
    if (cells != table.names.size()) {
      if (reading.anything && cut_off) break;  // the logger lost power
      throw Error(fmt::format("{}: {} cells, the header names {} columns", where(), cells,
                              table.names.size()));
    }
    for (std::size_t i = 0; i < row.size(); ++i) table.columns[i].push_back(row[i]);
  }
  if (table.names.empty()) throw Error(name + ": no header line with column names");
  return table;
}

}  // namespace

const std::vector<double>* Table::find(std::string_view name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? nullptr : &columns[static_cast<std::size_t>(found - names.begin())];
}

void Table::add(std::string name, std::vector<double> values) {
  names.push_back(std::move(name));
  columns.push_back(std::move(values));
}

Table parse_table(const std::string& text, const std::string& name) {
  return parse(text, name, {});
}

Table parse_log(const std::string& text, const std::string& name, std::vector<std::size_t>* words) {
  // The first line that is no remark decides.
  std::string_view header = text;
  while (!header.empty() && (header.front() == '#' || header.front() == '\n')) {
    const std::size_t end = header.find('\n', 1);
    header.remove_prefix(end == std::string_view::npos ? header.size() : end);
    if (header.starts_with('\n')) header.remove_prefix(1);
  }
  header = header.substr(0, header.find('\n'));
  Reading reading;
  reading.anything = true;
  reading.words = words;
  std::ptrdiff_t most = 0;
  for (const char separator : {',', ';', '\t'}) {
    const auto count = std::count(header.begin(), header.end(), separator);
    if (count > most) {
      most = count;
      reading.separator = separator;
    }
  }
  return parse(text, name, reading);
}

Table read_log(const std::string& path, std::vector<std::size_t>* words) {
  return parse_log(base::read_file(path, kLargestFileBytes), path, words);
}

Table read_table(const std::string& path) {
  return parse_table(base::read_file(path, kLargestFileBytes), path);
}

std::string format_table(const Table& table, int digits) {
  fmt::memory_buffer out;
  for (std::size_t c = 0; c < table.names.size(); ++c)
    fmt::format_to(std::back_inserter(out), "{}{}", c == 0 ? "" : ",", table.names[c]);
  out.push_back('\n');
  for (std::size_t r = 0; r < table.rows(); ++r) {
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      if (c > 0) out.push_back(',');
      const double value = table.columns[c][r];
      if (!std::isnan(value)) fmt::format_to(std::back_inserter(out), "{:.{}g}", value, digits);
    }
    out.push_back('\n');
  }
  return fmt::to_string(out);
}

}  // namespace vehicle
