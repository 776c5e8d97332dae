// How tables of text are written, decided in one place: separators, decimal marks, quotes, marks of
// byte order, blank lines and remarks.
#pragma once

#include <atomic>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace base {

/// What empty cells are to a reader.
enum class Gaps { refused, allowed };

/// The text behind its mark of byte order, if it has one. Throws Error where that says UTF-16.
std::string_view behind_byte_order_mark(std::string_view text, const std::string& path);

/// Whether a line has no cells: it is blank, or a remark, which begins with '#'.
bool is_blank_or_remark(std::string_view line);

/// The cells of a line, without the blanks around them. Quotes around a cell are taken off; what
/// they enclose may hold separators.
void split_cells(std::string_view line, char separator, std::vector<std::string_view>& cells);

/// Comma, semicolon or tab: that which makes most of the `wanted` names cells of the header, or
/// else most cells; of two alike not the comma, which may be a decimal one.
char separator_of(std::string_view header, const std::vector<std::string>& wanted = {});

/// A number with a decimal point or a decimal comma; nothing where the cell is none.
std::optional<double> number_with_comma(std::string_view cell);

/// A number with a decimal point or a decimal comma, of a table with that separator. Between commas
/// three digits behind a comma may be thousands (quoted "1,234"): nothing, unless 0 is before it.
std::optional<double> number_between(std::string_view cell, char separator);

/// What to do about a row with other than the `wanted` number of cells, after a semicolon. Says so
/// where decimal commas beside separating commas are the likely cause.
std::string advice_on_length(const std::vector<std::string_view>& cells, std::size_t wanted,
                             char separator);

/// What a header says about the rows below it. They have as many cells as it has names; separators
/// behind these are passed over. Decimals have points; where semicolons or
/// tabs separate they may have commas instead, all of them. Threads may share one.
class TableForm {
 public:
  /// `line` is the header's number, `path` is for messages, `wanted` for separator_of().
  TableForm(std::string_view header, std::size_t line, std::string path,
            const std::vector<std::string>& wanted = {});

  /// The names of the columns, up to the last that has one.
  const std::vector<std::string>& names() const { return names_; }
  /// The column of that name, or names().size(). Throws Error where there are two.
  std::size_t column(std::string_view name) const;
  /// Whether a line that is blank or begins with # is a row all the same: it has as many cells as
  /// the header names, as a row of empty cells or one called #1, and no blank behind the #.
  bool is_row(std::string_view line) const;
  /// One cell for each name. Throws Error with file:line where the row is longer or shorter.
  void split(std::string_view row, std::size_t line, std::vector<std::string_view>& cells) const;
  /// NaN for an empty cell or "nan", where gaps are allowed. Throws Error with file:line where the
  /// cell of that column is no number or infinite.
  double number(std::string_view cell, std::size_t column, std::size_t line,
                Gaps gaps = Gaps::allowed) const;

 private:
  std::string path_;
  std::size_t line_;  ///< of the header
  char separator_;
  std::vector<std::string> names_;
  mutable std::atomic<char> mark_ = 0;  ///< the decimal mark, once one was seen
};

}  // namespace base
