#include "csv_shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <set>

#include "base/error.h"
#include "base/table_form.h"
#include "base/text_lines.h"
#include "base/utf8.h"
#include "readers.h"
#include "recording/channels.h"

namespace recording {
namespace {

/// A number; `comma` stands for the decimal point too.
double number(std::string_view cell, bool comma) {
  const auto value = comma ? base::number_with_comma(cell) : base::to_number<double>(cell);
  return value && std::isfinite(*value) ? *value : std::numeric_limits<double>::quiet_NaN();
}

struct NumberedLine {
  std::string_view text;
  std::size_t number;
};

/// Not a separator: spreadsheets pad empty lines with them.
bool says_something(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || static_cast<unsigned char>(c) > 127;
}

/// "[Channel Data]": a title between the parts of a file, no part of a table.
bool is_title(std::string_view line) {
  line = base::trimmed(line);
  return line.starts_with('[') && line.ends_with(']') &&
         line.find_first_of(",;\t]") == line.size() - 1;
}

/// What stands at the beginning, without titles: enough to see where the numbers begin.
std::vector<NumberedLine> head_of(std::string_view text) {
  constexpr std::size_t kMostLines = 300;
  std::vector<NumberedLine> out;
  base::Lines lines(text);
  std::string_view line;
  while (out.size() < kMostLines && lines.next(line))
    if (std::any_of(line.begin(), line.end(), says_something) && !is_title(line))
      out.push_back({line, lines.number()});
  return out;
}

/// What the cells of one line are.
struct Look {
  std::size_t cells = 0, numbers = 0, words = 0, units = 0;
  std::size_t filled = 0;  ///< cells without the empty ones at the end
};
Look look_at(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  base::split_cells(line, separator, cells);
  Look out{cells.size()};
  for (const std::string_view& cell : cells) {
    if (cell.empty()) continue;
    out.filled = static_cast<std::size_t>(&cell - cells.data()) + 1;
    const bool is_number = std::isfinite(number(cell, separator != ','));
    ++(is_number ? out.numbers : out.words);
    out.units += !is_number && is_unit(cell) ? 1 : 0;
  }
  return out;
}

void take_names(std::string_view line, Shape& shape) {
  std::vector<std::string_view> cells;
  base::split_cells(line, shape.separator, cells);
  while (!shape.exported && cells.size() > 1 && cells.back().empty()) cells.pop_back();
  for (const std::string_view cell : cells) shape.names.emplace_back(cell);
}

/// A log that begins with its header, or with remarks and its header: as ever.
bool plain_shape(const std::vector<NumberedLine>& head, Shape& shape) {
  std::size_t h = 0;
  while (h < head.size() && base::trimmed(head[h].text).starts_with('#')) ++h;
  if (h == head.size()) return false;
  shape.separator = base::separator_of(head[h].text);
  const Look first = look_at(head[h].text, shape.separator);
  // Numbers at once: a remark before them is the header, if it has as many cells.
  if (first.words == 0 && first.numbers > 1 && h > 0) {
    std::string_view line = base::trimmed(head[h - 1].text);
    line.remove_prefix(std::min(line.find_first_not_of("# \t"), line.size()));
    const Look header = look_at(line, shape.separator);
    if (header.cells == first.cells && header.numbers == 0 && header.words == header.cells) {
      take_names(line, shape);
      shape.header_line = head[h - 1].number;
      shape.data_line = head[h].number;
      return true;
    }
  }
  std::size_t next = h + 1;
  while (next < head.size() && base::trimmed(head[next].text).starts_with('#')) ++next;
  if (next < head.size()) {
    const Look second = look_at(head[next].text, shape.separator);
    // A preamble, or units: an export.
    const auto ends_like_it = [&](std::size_t from_end) {
      return head.size() <= next + from_end ||
             look_at(head[head.size() - from_end].text, shape.separator).cells == first.cells;
    };
    if (!ends_like_it(1) && (second.cells != first.cells || !ends_like_it(2))) return false;
    if (second.numbers == 0 && second.units > 0) return false;
    if (first.cells == 1 && second.cells == 1 && head.size() > 3 &&
        head.back().text.find_first_of(",;\t") != std::string_view::npos)
      return false;
  }
  take_names(head[h].text, shape);
  shape.header_line = head[h].number;
  shape.data_line = head[h].number + 1;
  return true;
}

/// Of lines [first, last) with as many cells, the one with the names: the highest without gaps.
/// Above it may stand a preamble that a spreadsheet has padded, below it units and sources.
std::size_t names_among(const std::vector<NumberedLine>& head, std::size_t first, std::size_t last,
                        char separator) {
  std::size_t best = first, most = 0;
  for (std::size_t k = first; k < last; ++k) {
    const Look look = look_at(head[k].text, separator);
    // A preamble is in pairs, too.
    if (look.cells == 2 && k + 1 < last && look_at(head[k + 1].text, separator).units == 2)
      return k;
    if (look.numbers + look.words > most) best = k, most = look.numbers + look.words;
  }
  return best;
}

/// A line of units, or of what measured each column ("100: gps").
void take_below_names(std::string_view line, Shape& shape) {
  std::vector<std::string_view> cells;
  base::split_cells(line, shape.separator, cells);
  const Look look = look_at(line, shape.separator);
  // RPM is a name, too, and some write the names twice.
  const bool are_units = look.units > 0 && (3 * look.units > look.words || cells.front().empty() ||
                                            is_unit(cells.front()));
  std::vector<std::string>& into = are_units ? shape.units : shape.sources;
  if (!into.empty()) return;
  for (std::string_view cell : cells) {
    if (are_units && cell.size() > 2 && (cell.front() == '[' || cell.front() == '('))
      cell = cell.substr(1, cell.size() - 2);
    if (const std::size_t at = cell.find(": "); !are_units && at != std::string_view::npos)
      cell.remove_prefix(at + 2);
    into.emplace_back(cell);
  }
}

/// What the preamble of AiM says of the whole log.
void take_preamble(const std::vector<NumberedLine>& head, std::size_t end, Shape& shape) {
  std::vector<std::string_view> cells;
  for (std::size_t k = 0; k < end; ++k) {
    base::split_cells(head[k].text, shape.separator, cells);
    const auto seconds = [&](std::size_t c) { return base::to_number<double>(cells[c]); };
    if (cells.size() > 1 && cells[0] == "Duration")
      shape.stated_s = std::max(0.0, seconds(1).value_or(0.0));
    if (cells.size() > 1 && cells[0] == "Beacon Markers")
      for (std::size_t c = 1; c < cells.size(); ++c)
        for (std::string_view rest = cells[c]; !rest.empty();)  // MoTeC has all in one cell
          if (const auto at_s = base::to_number<double>(base::take_word(rest));
              at_s && std::isfinite(*at_s))
            shape.beacons_s.push_back(*at_s);
  }
}

/// Whether a line numbers the channels: whole numbers or nothing in all cells but the clock's,
/// which is empty, as it is in no row below.
bool numbers_channels(std::string_view line, std::string_view below, char separator) {
  std::vector<std::string_view> cells, under;
  base::split_cells(line, separator, cells);
  base::split_cells(below, separator, under);
  return cells.size() > 2 && under.size() <= cells.size() && cells.front().empty() &&
         !under.front().empty() && std::all_of(cells.begin() + 1, cells.end(), [](auto cell) {
           return cell.find_first_not_of("0123456789") == std::string_view::npos;
         });
}

/// A logger's export: the first line of numbers that goes on as such, and what stands before it.
bool exported_shape(const std::vector<NumberedLine>& head, Shape& shape) {
  for (std::size_t d = 1; d < head.size(); ++d) {
    const char separator = base::separator_of(head[d].text);
    // In "0,00;1,50" the commas are many, too.
    for (const char candidate : {';', '\t', separator}) {
      const Look look = look_at(head[d].text, candidate);
      if (look.cells < 2 || look.numbers < 2 || look.numbers < look.words) continue;
      const bool numbered =
          d + 1 < head.size() && numbers_channels(head[d].text, head[d + 1].text, candidate);
      const std::size_t columns =
          numbered ? look_at(head[d + 1].text, candidate).cells : look.cells;
      // Some end their lines of names with a separator, and not the rows.
      const auto fits = [&](const Look& line) {
        return line.cells == columns || (line.cells > columns && line.filled <= columns);
      };
      if (!fits(look)) continue;
      if (d + 1 < head.size() && look_at(head[d + 1].text, candidate).cells != columns) continue;
      std::size_t h = d;  // the highest line of words with as many cells
      while (h > 0) {
        const Look above = look_at(head[h - 1].text, candidate);
        if (!fits(above) || above.numbers > above.words) break;
        --h;
      }
      if (h == d) continue;
      h = names_among(head, h, d, candidate);
      const Look names = look_at(head[h].text, candidate);
      if (names.numbers + names.words < look.numbers + look.words) continue;  // a preamble's row
      shape.separator = candidate;
      shape.exported = true;
      shape.header_line = head[h].number;
      shape.data_line = head[numbered ? d + 1 : d].number;
      take_names(head[h].text, shape);
      if (shape.names.size() > columns) shape.names.resize(columns);
      take_preamble(head, h, shape);
      for (std::size_t k = h + 1; k < d; ++k) take_below_names(head[k].text, shape);
      return true;
    }
  }
  return false;
}

/// The names of a plain header: not most of them are numbers. In a table of ours each column has a
/// name, but for a first one that counts the rows, and a channel stands there once.
void check_names(const Shape& shape, const std::string& name) {
  std::set<std::string_view> seen;
  const std::vector<std::string>& own = canonical_channels();
  const bool is_own =
      std::find(shape.names.begin(), shape.names.end(), "time_s") != shape.names.end();
  for (const std::string& column : shape.names) {
    if (column.empty() && is_own && &column != &shape.names.front())
      throw base::Error(fmt::format("{}:{}: a column without a name", name, shape.header_line));
    if (column.empty() || seen.insert(column).second) continue;
    if (std::isfinite(number(column, true)))
      throw base::Error(fmt::format(
          "{}:{}: '{:.40}' twice in the first line, where names of columns are wanted: rows of "
          "several kinds, or no header? Write one table with a line of names",
          name, shape.header_line, column));
    if (is_own && std::find(own.begin(), own.end(), column) != own.end())
      throw base::Error(
          fmt::format("{}:{}: column '{}' twice; take one away", name, shape.header_line, column));
  }
  const auto is_number = [](const std::string& cell) { return std::isfinite(number(cell, true)); };
  const auto numbers = std::count_if(shape.names.begin(), shape.names.end(), is_number);
  if (2 * static_cast<std::size_t>(numbers) > shape.names.size())
    throw base::Error(fmt::format(
        "{}:{}: numbers ('{:.40}', ...) where the names of columns are wanted; put a line of names "
        "above the rows",
        name, shape.header_line, *std::find_if(shape.names.begin(), shape.names.end(), is_number)));
}

}  // namespace

bool is_unit(std::string_view cell) {
  static const std::set<std::string, std::less<>> known{
      "s",     "ms",    "us",   "ns",   "min",   "m",     "km",        "mm",    "ft",  "mi",
      "deg",   "rad",   "m/s",  "km/h", "kmh",   "kph",   "mph",       "knots", "g",   "%",
      "deg/s", "rad/s", "m/s2", "m/s²", "m/s^2", "m/s/s", "rpm",       "1/min", "bar", "kpa",
      "sec",   "msec",  "mbar", "mpa",  "psi",   "c",     "degc",      "degf",  "k",   "v",
      "nm",    "n",     "°",    "°/s",  "°c",    "°f",    "unix time", "kn"};
  std::string lower;
  for (const char c : base::in_utf8(cell))
    if (c != '[' && c != ']' && c != '(' && c != ')')
      lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return known.contains(lower);
}

Shape shape_of(std::string_view text, const std::string& name) {
  const std::vector<NumberedLine> head = head_of(text);
  Shape shape;
  Shape other;
  const bool exported = exported_shape(head, other);
  if (exported && !other.units.empty()) {
    shape = other;
  } else if (!plain_shape(head, shape)) {
    if (exported) {
      shape = other;
    } else if (shape.names.empty()) {
      std::size_t h = 0;
      while (h < head.size() && base::trimmed(head[h].text).starts_with('#')) ++h;
      if (h == head.size()) throw base::Error(name + ": no header line with column names");
      shape.separator = base::separator_of(head[h].text);
      take_names(head[h].text, shape);
      shape.header_line = head[h].number;
      shape.data_line = shape.header_line + 1;
    }
  }
  if (!shape.exported) check_names(shape, name);
  return shape;
}

}  // namespace recording
