// Numeric columns of a CSV file, picked by their header names.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "base/table_form.h"

namespace base {

/// Values of the wanted columns, row after row; an empty cell is NaN.
struct CsvTable {
  static constexpr std::size_t kAbsent = std::numeric_limits<std::size_t>::max();
  std::size_t columns = 0;         ///< number of wanted columns, required first
  std::vector<std::string> names;  ///< of the wanted columns
  std::vector<bool> present;       ///< whether the file has wanted column j; required ones always
  std::vector<double> values;      ///< rows * columns; NaN where absent or empty
  std::vector<std::size_t> line;   ///< of the file, per row

  std::size_t rows() const { return columns == 0 ? 0 : values.size() / columns; }
  double value(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
};

/// Reads a table of text (base/table_form.h) with one header line, which may begin with '#' (other
/// lines that do are skipped). Other columns are ignored. Throws Error with file:line on a missing
/// required column (lists those seen), a wanted one that is there twice, a row that is longer or
/// shorter than the header, a cell that is not a number, or an empty one in a required column.
CsvTable read_csv(const std::string& path, const std::vector<std::string>& required,
                  const std::vector<std::string>& optional = {}, Gaps gaps = Gaps::refused);

/// The same with all columns that the file has wanted and filled, the required ones first.
CsvTable read_whole_csv(const std::string& path, const std::vector<std::string>& required);

}  // namespace base
