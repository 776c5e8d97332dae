#include "recording/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>

#include "base/error.h"
#include "base/read_file.h"
#include "base/text_lines.h"

namespace recording {
namespace {

constexpr std::size_t kLargestFileBytes = std::size_t{1} << 30;

/// Calls f(cell, index) for every cell and returns their number.
template <class F>
std::size_t for_each_cell(std::string_view line, F&& f) {
  std::size_t index = 0;
  for (;;) {
    const std::size_t comma = line.find(',');
    f(base::trimmed(line.substr(0, comma)), index++);
    if (comma == std::string_view::npos) return index;
    line.remove_prefix(comma + 1);
  }
}

Table parse(const std::string& text, const std::string& name) {
  Table table;
  std::size_t line_number = 0;
  std::string_view rest = text;
  if (rest.starts_with("\xef\xbb\xbf")) rest.remove_prefix(3);
  std::vector<double> row;
  while (!rest.empty()) {
    const std::size_t end = rest.find('\n');
    const std::string_view line = base::trimmed(rest.substr(0, end));
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    ++line_number;
    if (line.empty() || line.front() == '#') continue;
    const auto where = [&] { return fmt::format("{}:{}", name, line_number); };
    if (table.names.empty()) {
      for_each_cell(line, [&](std::string_view cell, std::size_t) {
        if (cell.empty()) throw base::Error(where() + ": a column without a name");
        if (std::find(table.names.begin(), table.names.end(), cell) != table.names.end())
          throw base::Error(fmt::format("{}: column '{}' twice", where(), cell.substr(0, 40)));
        table.names.emplace_back(cell);
      });
      table.columns.resize(table.names.size());
      row.resize(table.names.size());
      continue;
    }
    const std::size_t cells = for_each_cell(line, [&](std::string_view cell, std::size_t index) {
      if (index >= table.names.size()) return;
      double value = std::numeric_limits<double>::quiet_NaN();
      if (!cell.empty()) {
        std::string_view digits = cell;
        if (digits.front() == '+') digits.remove_prefix(1);
        const auto [stop, error] =
            std::from_chars(digits.data(), digits.data() + digits.size(), value);
        if (error != std::errc() || stop != digits.data() + digits.size() || !std::isfinite(value))
          throw base::Error(fmt::format("{}: '{}' in column {}, wanted a finite number or nothing",
                                        where(), cell.substr(0, 40),
                                        table.names[index].substr(0, 40)));
      }
      row[index] = value;
    });
    if (cells != table.names.size())
      throw base::Error(fmt::format("{}: {} cells, the header names {} columns", where(), cells,
                                    table.names.size()));
    for (std::size_t i = 0; i < row.size(); ++i) table.columns[i].push_back(row[i]);
  }
  if (table.names.empty()) throw base::Error(name + ": no header line with column names");
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

Table parse_table(const std::string& text, const std::string& name) { return parse(text, name); }

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

}  // namespace recording
