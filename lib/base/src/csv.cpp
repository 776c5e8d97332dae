#include "base/csv.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <string_view>

#include "base/error.h"
#include "base/read_file.h"
#include "base/text_lines.h"

namespace base {

namespace {

void split(std::string_view line, std::vector<std::string_view>& cells) {
  cells.clear();
  for (;;) {
    const auto comma = line.find(',');
    cells.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
}

}  // namespace

CsvTable read_csv(const std::string& path, const std::vector<std::string>& required,
                  const std::vector<std::string>& optional) {
  const std::string text = base::read_file(path);

  std::vector<std::string> wanted = required;
  wanted.insert(wanted.end(), optional.begin(), optional.end());
  CsvTable table;
  table.columns = wanted.size();
  std::vector<std::size_t> source;  // column of the file per wanted column
  std::vector<std::string_view> cells;
  std::size_t line_number = 0, needed = 0;
  bool behind_remark = false;  // that named the columns: the line after it may be the header, too
  std::string_view rest = text;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
  while (!rest.empty()) {
    const auto end = rest.find('\n');
    const std::string_view line = trimmed(rest.substr(0, end));
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    ++line_number;
    if (line.empty()) continue;
    const bool remark = line.front() == '#';
    if (remark && !source.empty()) continue;
    split(remark ? trimmed(line.substr(1)) : line, cells);
    const bool names_all = std::all_of(required.begin(), required.end(), [&](const auto& name) {
      return std::find(cells.begin(), cells.end(), name) != cells.end();
    });
    if (remark && !names_all) continue;
    if (behind_remark && names_all) source.clear(), table.present.clear(), needed = 0;
    behind_remark = remark;
    if (source.empty()) {
      for (std::size_t j = 0; j < wanted.size(); ++j) {
        const auto found = std::find(cells.begin(), cells.end(), wanted[j]);
        if (found == cells.end() && j < required.size()) {
          throw Error(
              fmt::format("{}:{}: no column '{}'; saw '{:.120}'; the header line must name {}",
                          path, line_number, wanted[j], line, fmt::join(required, ",")));
        }
        table.present.push_back(found != cells.end());
        source.push_back(found == cells.end() ? CsvTable::kAbsent
                                              : static_cast<std::size_t>(found - cells.begin()));
        if (source.back() != CsvTable::kAbsent) needed = std::max(needed, source.back() + 1);
      }
      continue;
    }
    if (cells.size() < needed) {
      throw Error(fmt::format("{}:{}: {} cells, wanted at least {} as in the header line", path,
                              line_number, cells.size(), needed));
    }
    table.line.push_back(line_number);
    for (std::size_t j = 0; j < wanted.size(); ++j) {
      double value = std::numeric_limits<double>::quiet_NaN();
      if (source[j] != CsvTable::kAbsent && !cells[source[j]].empty()) {
        const std::optional<double> number = to_number<double>(cells[source[j]]);
        if (!number)
          throw Error(
              fmt::format("{}:{}: column '{}' holds '{:.40}', wanted a number or an empty cell",
                          path, line_number, wanted[j], cells[source[j]]));
        value = *number;
      }
      table.values.push_back(value);
    }
  }
  if (source.empty())
    throw Error(
        fmt::format("{}: empty; wanted a header line with {}", path, fmt::join(required, ",")));
  return table;
}

}  // namespace base
