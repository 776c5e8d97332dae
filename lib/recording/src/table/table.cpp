#include "recording/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <unordered_set>

#include "base/error.h"
#include "base/read_file.h"
#include "base/table_form.h"
#include "base/text_lines.h"

namespace recording {
namespace {

constexpr std::size_t kLargestFileBytes = std::size_t{1} << 30;

void check_names(const std::vector<std::string>& names, const std::string& where) {
  std::unordered_set<std::string_view> seen;
  for (const std::string& name : names) {
    if (name.empty()) throw base::Error(where + ": a column without a name");
    if (!seen.insert(name).second)
      throw base::Error(fmt::format("{}: column '{}' twice", where, name.substr(0, 40)));
  }
}

Table parse(const std::string& text, const std::string& name, base::Gaps gaps) {
  Table table;
  std::optional<base::TableForm> form;
  base::Lines lines(base::behind_byte_order_mark(text, name));
  std::string_view line;
  std::vector<std::string_view> cells;
  while (lines.next(line)) {
    if (base::is_blank_or_remark(line)) continue;
    const std::size_t number = lines.number();
    if (!form) {
      form.emplace(line, number, name);
      table.names = form->names();
      check_names(table.names, fmt::format("{}:{}", name, number));
      table.columns.resize(table.names.size());
      // Axes of maps are numbers, with the decimal mark of all others.
      for (std::size_t c = 0; c < table.names.size(); ++c)
        if (std::string& axis = table.names[c];
            axis.find(',') != std::string::npos && base::number_with_comma(axis))
          axis = fmt::format("{}", form->number(axis, c, number));
      continue;
    }
    form->split(line, number, cells);
    table.lines.push_back(number);
    for (std::size_t c = 0; c < cells.size(); ++c) {
      const double value = form->number(cells[c], c, number, gaps);
      if (!cells[c].empty() && !std::isfinite(value))
        throw base::Error(
            fmt::format("{}:{}: '{}' in column '{}', wanted a finite number or nothing", name,
                        number, cells[c].substr(0, 40), table.names[c].substr(0, 40)));
      table.columns[c].push_back(value);
    }
  }
  if (!form) throw base::Error(name + ": no header line with column names");
  return table;
}

}  // namespace

const std::vector<double>* Table::find(std::string_view name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? nullptr : &columns[static_cast<std::size_t>(found - names.begin())];
}

std::string Table::place(const std::string& name, std::size_t row) const {
  return row < lines.size() ? fmt::format("{}:{}", name, lines[row])
                            : fmt::format("{}, row {}", name, row + 1);
}

void Table::add(std::string name, std::vector<double> values) {
  names.push_back(std::move(name));
  columns.push_back(std::move(values));
}

Table parse_table(const std::string& text, const std::string& name, base::Gaps gaps) {
  return parse(text, name, gaps);
}

Table read_table(const std::string& path, base::Gaps gaps) {
  return parse_table(base::read_file(path, kLargestFileBytes), path, gaps);
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
