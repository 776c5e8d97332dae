#include "base/table_form.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"
#include "base/text_lines.h"

namespace base {

namespace {

bool is_digits(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

/// Whether "0,5" between commas can have become two of these cells.
bool may_be_decimal_commas(const std::vector<std::string_view>& cells) {
  bool pair = false;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    if (cells[c].find('.') != std::string_view::npos) return false;
    if (c == 0) continue;
    std::string_view whole = cells[c - 1];
    if (whole.starts_with('-') || whole.starts_with('+')) whole.remove_prefix(1);
    pair = pair || (is_digits(whole) && is_digits(cells[c]));
  }
  return pair;
}

}  // namespace

std::string_view behind_byte_order_mark(std::string_view text, const std::string& path) {
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
    throw Error(path + ": UTF-16 seen, UTF-8 wanted; save the table as UTF-8");
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  return text;
}

bool is_blank_or_remark(std::string_view line) {
  line = trimmed(line);
  return line.empty() || line.front() == '#';
}

void split_cells(std::string_view line, char separator, std::vector<std::string_view>& cells) {
  cells.clear();
  const bool quotes = line.find('"') != std::string_view::npos;
  for (;;) {
    std::size_t end = line.find(separator);
    const std::size_t open =
        quotes ? line.find_first_not_of(separator == '\t' ? " " : " \t") : std::string_view::npos;
    if (open != std::string_view::npos && line[open] == '"') {
      std::size_t close = line.find('"', open + 1);
      while (close != std::string_view::npos && line.substr(close + 1).starts_with('"'))
        close = line.find('"', close + 2);
      if (close != std::string_view::npos) end = line.find(separator, close);
    }
    std::string_view cell = trimmed(line.substr(0, end));
    if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"')
      cell = trimmed(cell.substr(1, cell.size() - 2));
    cells.push_back(cell);
    if (end == std::string_view::npos) return;
    line.remove_prefix(end + 1);
  }
}

char separator_of(std::string_view header, const std::vector<std::string>& wanted) {
  char best = ',';
  std::pair<std::ptrdiff_t, std::size_t> most{0, 1};
  std::vector<std::string_view> cells;
  for (const char separator : {';', '\t', ','}) {  // a comma may be a decimal one
    split_cells(header, separator, cells);
    const auto named = std::count_if(wanted.begin(), wanted.end(), [&](const std::string& name) {
      return std::find(cells.begin(), cells.end(), name) != cells.end();
    });
    if (const std::pair found{named, cells.size()}; found > most) most = found, best = separator;
  }
  return best;
}

std::optional<double> number_with_comma(std::string_view cell) {
  std::array<char, 64> text;
  if (cell.size() <= text.size() && cell.find(',') != std::string_view::npos) {
    std::replace_copy(cell.begin(), cell.end(), text.begin(), ',', '.');
    cell = {text.data(), cell.size()};
  }
  return to_number<double>(cell);
}

std::optional<double> number_between(std::string_view cell, char separator) {
  const std::size_t comma = separator == ',' ? cell.find(',') : std::string_view::npos;
  const bool doubtful = comma != std::string_view::npos && cell.size() - comma == 4 &&
                        is_digits(cell.substr(comma + 1)) &&
                        cell.substr(0, comma).find_first_of("123456789") != std::string_view::npos;
  return doubtful ? std::nullopt : number_with_comma(cell);
}

std::string advice_on_length(const std::vector<std::string_view>& cells, std::size_t wanted,
                             char separator) {
  if (cells.size() < wanted) return "; fill in what is missing: an empty cell has its separator";
  if (separator == ',' && may_be_decimal_commas(cells))
    return "; these look like decimal commas: write points, or separate the cells by semicolons";
  return "; take away what is too much";
}

TableForm::TableForm(std::string_view header, std::size_t line, std::string path,
                     const std::vector<std::string>& wanted)
    : path_(std::move(path)), line_(line), separator_(separator_of(header, wanted)) {
  std::vector<std::string_view> cells;
  split_cells(header, separator_, cells);
  while (!cells.empty() && cells.back().empty()) cells.pop_back();
  names_.assign(cells.begin(), cells.end());
}

std::size_t TableForm::column(std::string_view name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found != names_.end() && std::find(found + 1, names_.end(), name) != names_.end())
    throw Error(
        fmt::format("{}:{}: two columns are called '{:.60}'; take one away", path_, line_, name));
  return static_cast<std::size_t>(found - names_.begin());
}

bool TableForm::is_row(std::string_view line) const {
  std::vector<std::string_view> cells;
  split_cells(line, separator_, cells);
  while (cells.size() > names_.size() && cells.back().empty()) cells.pop_back();
  return cells.size() == names_.size() && !line.starts_with("# ");
}

void TableForm::split(std::string_view row, std::size_t line,
                      std::vector<std::string_view>& cells) const {
  split_cells(row, separator_, cells);
  const std::size_t wanted = names_.size();
  if (cells.size() == wanted) return;
  // Some loggers end every row with a separator, or the header alone.
  const bool fits = cells.size() > wanted &&
                    std::all_of(cells.begin() + static_cast<std::ptrdiff_t>(wanted), cells.end(),
                                [](std::string_view cell) { return cell.empty(); });
  if (!fits)
    throw Error(fmt::format(
        "{}:{}: '{:.60}' has {} cells, the header in line {} names {} columns{}", path_, line,
        trimmed(row), cells.size(), line_, wanted, advice_on_length(cells, wanted, separator_)));
  cells.resize(wanted);
}

double TableForm::number(std::string_view cell, std::size_t column, std::size_t line,
                         Gaps gaps) const {
  const std::optional<double> value =
      cell.empty() ? std::numeric_limits<double>::quiet_NaN() : number_between(cell, separator_);
  if (!value || std::isinf(*value))
    throw Error(
        fmt::format("{}:{}: column '{:.40}' holds '{:.40}', wanted a {}number or an empty cell{}",
                    path_, line, names_[column], cell, value ? "finite " : "",
                    !value && number_with_comma(cell) ? "; write a point for the comma" : ""));
  if (gaps == Gaps::refused && std::isnan(*value))
    throw Error(
        fmt::format("{}:{}: column '{:.40}' {}, wanted a number; fill it in, or take the row out",
                    path_, line, names_[column], cell.empty() ? "is empty" : "holds no number"));
  const auto at =
      std::find_if(cell.begin(), cell.end(), [](char c) { return c == ',' || c == '.'; });
  if (at != cell.end()) {
    char seen = mark_.load(std::memory_order_relaxed);  // an exchange alone costs all threads
    if (seen == 0 && mark_.compare_exchange_strong(seen, *at)) seen = *at;
    if (seen != *at)
      throw Error(
          fmt::format("{}:{}: column '{:.40}' holds '{:.40}', but other decimals of this "
                      "table have '{}'; write all alike",
                      path_, line, names_[column], cell, seen));
  }
  return *value;
}

}  // namespace base
