// Tables of numbers with named columns: text with one header line.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/table_form.h"

namespace recording {

/// Columns of equal length; NaN is an empty cell.
struct Table {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;  ///< columns[i] belongs to names[i]
  std::vector<std::size_t> lines = {};       ///< of the file, per row; empty: of no file

  std::size_t rows() const { return columns.empty() ? 0 : columns.front().size(); }
  /// The column of that name, or nullptr.
  const std::vector<double>* find(std::string_view name) const;
  /// Where a row stands, for messages: "name:line", or "name, row 3".
  std::string place(const std::string& name, std::size_t row) const;
  void add(std::string name, std::vector<double> values);
};

/// Reads a table: first line names, then numbers; empty cells become NaN, lines beginning with '#'
/// and empty lines are skipped. Throws Error with file:line on anything else: a name twice, a cell
/// that is no finite number, a line with too few or too many cells,
/// an empty cell where gaps are refused.
Table read_table(const std::string& path, base::Gaps gaps = base::Gaps::allowed);
Table parse_table(const std::string& text, const std::string& name,
                  base::Gaps gaps = base::Gaps::allowed);

/// The table as text, numbers with `digits` significant digits (17 read back exactly), NaN empty.
std::string format_table(const Table& table, int digits = 9);

}  // namespace recording
