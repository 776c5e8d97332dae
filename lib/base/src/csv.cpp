#include "base/csv.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/read_file.h"
#include "base/table_form.h"
#include "base/text_lines.h"

namespace base {

namespace {

bool has(const TableForm& form, const std::string& name) {
  return form.column(name) < form.names().size();
}

/// The column of the file for each of table.names, of which the first ones are required.
std::vector<std::size_t> columns_of(const TableForm& form, const std::vector<std::string>& required,
                                    std::string_view header, const std::string& place,
                                    CsvTable& table) {
  std::vector<std::size_t> source;
  for (const std::string& name : table.names) {
    table.present.push_back(has(form, name));
    source.push_back(table.present.back() ? form.column(name) : CsvTable::kAbsent);
    if (!table.present.back() && source.size() <= required.size())
      throw Error(fmt::format("{}: no column '{}'; saw '{:.120}'; the header line must name {}",
                              place, name, trimmed(header), fmt::join(required, ",")));
  }
  return source;
}

CsvTable read(const std::string& path, const std::vector<std::string>& required,
              const std::vector<std::string>& optional, bool whole, Gaps gaps) {
  const std::string text = base::read_file(path);
  std::vector<std::string> wanted = required;
  wanted.insert(wanted.end(), optional.begin(), optional.end());
  CsvTable table;
  std::unique_ptr<TableForm> form;
  std::vector<std::size_t> source;  // column of the file per wanted column
  std::vector<std::string_view> cells;
  bool behind_remark = false;  // that named the columns: the line after it may be the header, too
  Lines lines(behind_byte_order_mark(text, path));
  std::string_view line;
  while (lines.next(line)) {
    const std::string_view inside = trimmed(line);
    const bool remark = inside.starts_with('#');
    if (inside.empty() || (remark && form)) continue;
    if (!form || behind_remark) {
      const std::string_view header = remark ? inside.substr(1) : line;
      auto next = std::make_unique<TableForm>(header, lines.number(), path, wanted);
      const auto named = [&](const std::string& name) { return has(*next, name); };
      const bool names_all = std::all_of(required.begin(), required.end(), named) &&
                             std::any_of(wanted.begin(), wanted.end(), named);
      if (remark && !names_all) continue;
      behind_remark = remark;
      if (!form || names_all) {
        form = std::move(next);
        table.names = wanted;
        for (const std::string& name : form->names())
          if (whole && std::count(wanted.begin(), wanted.end(), name) == 0)
            table.names.push_back(name);
        table.present.clear();
        source =
            columns_of(*form, required, header, fmt::format("{}:{}", path, lines.number()), table);
        continue;
      }
    }
    form->split(line, lines.number(), cells);
    table.line.push_back(lines.number());
    const std::size_t filled = whole ? source.size() : gaps == Gaps::refused ? required.size() : 0;
    for (std::size_t k = 0; k < source.size(); ++k) {
      const std::size_t column = source[k];
      table.values.push_back(column == CsvTable::kAbsent
                                 ? std::numeric_limits<double>::quiet_NaN()
                                 : form->number(cells[column], column, lines.number(),
                                                k < filled ? Gaps::refused : Gaps::allowed));
    }
  }
  if (!form)
    throw Error(
        fmt::format("{}: empty; wanted a header line with {}", path, fmt::join(required, ",")));
  table.columns = table.names.size();
  return table;
}

}  // namespace

CsvTable read_csv(const std::string& path, const std::vector<std::string>& required,
                  const std::vector<std::string>& optional, Gaps gaps) {
  return read(path, required, optional, false, gaps);
}

CsvTable read_whole_csv(const std::string& path, const std::vector<std::string>& required) {
  return read(path, required, {}, true, Gaps::refused);
}

}  // namespace base
