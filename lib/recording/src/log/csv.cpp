// Logs as text: where the header is, what stands before and after it, and the cells.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "base/error.h"
#include "base/table_form.h"
#include "base/text_lines.h"
#include "iso_time.h"
#include "readers.h"

namespace recording {
namespace {

/// A number; `comma` stands for the decimal point too.
double number(std::string_view cell, bool comma) {
  const auto value = comma ? base::number_with_comma(cell) : base::to_number<double>(cell);
  return value && std::isfinite(*value) ? *value : std::numeric_limits<double>::quiet_NaN();
}

/// Whether a cell that is no number would be one without the separators of its thousands, or with a
/// point for a comma.
bool is_number_with_commas(std::string_view cell) {
  if (cell.find(',') == std::string_view::npos) return false;
  if (std::isfinite(number(cell, true))) return true;
  if (cell.starts_with('-') || cell.starts_with('+')) cell.remove_prefix(1);
  for (bool first = true;; first = false) {
    const std::size_t digits = std::min(cell.find_first_not_of("0123456789"), cell.size());
    if (digits == cell.size()) return digits > 0;
    if ((cell[digits] != ',' && cell[digits] != '.') || digits > 3 || digits < (first ? 1 : 3))
      return false;
    cell.remove_prefix(digits + 1);
  }
}

struct Shape {
  char separator = ',';
  std::size_t header_line = 0, data_line = 0;
  std::vector<std::string> names, units;
  bool exported = false;  ///< by a logger's program, with units
};

struct NumberedLine {
  std::string_view text;
  std::size_t number;
};

/// What stands at the beginning: enough to see where the numbers begin.
std::vector<NumberedLine> head_of(std::string_view text) {
  constexpr std::size_t kMostLines = 300;
  std::vector<NumberedLine> out;
  base::Lines lines(text);
  std::string_view line;
  while (out.size() < kMostLines && lines.next(line))
    if (!base::trimmed(line).empty()) out.push_back({line, lines.number()});
  return out;
}

/// What the cells of one line are.
struct Look {
  std::size_t cells = 0, numbers = 0, words = 0, units = 0;
};
Look look_at(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  base::split_cells(line, separator, cells);
  Look out{cells.size()};
  for (const std::string_view cell : cells) {
    if (cell.empty()) continue;
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
    if (second.cells != first.cells &&
        look_at(head.back().text, shape.separator).cells != first.cells)
      return false;
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

/// A logger's export: the first line of numbers that goes on as such, and what stands before it.
bool exported_shape(const std::vector<NumberedLine>& head, Shape& shape) {
  for (std::size_t d = 1; d < head.size(); ++d) {
    const char separator = base::separator_of(head[d].text);
    // In "0,00;1,50" the commas are many, too.
    for (const char candidate : {';', '\t', separator}) {
      const Look look = look_at(head[d].text, candidate);
      if (look.cells < 3 || look.numbers < 2 || look.numbers < look.words) continue;
      if (d + 1 < head.size() && look_at(head[d + 1].text, candidate).cells != look.cells) continue;
      std::size_t h = d;  // the highest line of words with as many cells
      while (h > 0) {
        const Look above = look_at(head[h - 1].text, candidate);
        if (above.cells != look.cells || above.numbers > above.words) break;
        --h;
      }
      if (h == d) continue;
      // Sources and remarks of the columns may stand between; names are the first without gaps.
      shape.separator = candidate;
      shape.exported = true;
      shape.header_line = head[h].number;
      shape.data_line = head[d].number;
      take_names(head[h].text, shape);
      for (std::size_t k = h + 1; k < d; ++k)
        if (look_at(head[k].text, candidate).units > 0 && shape.units.empty()) {
          std::vector<std::string_view> cells;
          base::split_cells(head[k].text, candidate, cells);
          for (std::string_view cell : cells) {
            if (cell.size() > 2 && (cell.front() == '[' || cell.front() == '('))
              cell = cell.substr(1, cell.size() - 2);
            shape.units.emplace_back(cell);
          }
        }
      return true;
    }
  }
  return false;
}

void check_names(const Shape& shape, const std::string& name) {
  std::set<std::string_view> seen;
  for (const std::string& column : shape.names) {
    if (column.empty())
      throw base::Error(fmt::format("{}:{}: a column without a name", name, shape.header_line));
    if (!seen.insert(column).second)
      throw base::Error(
          fmt::format("{}:{}: column '{}' twice", name, shape.header_line, column.substr(0, 40)));
  }
}

/// The clock among the channels, in seconds as far as its unit tells.
const Channel* clock_of(const Log& log) {
  for (const Channel& channel : log.channels) {
    std::string word;
    for (const char c : channel.name)
      if (std::isalnum(static_cast<unsigned char>(c)) != 0)
        word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (word.starts_with("time") || word == "t" || word == "ts" || word.starts_with("zeit") ||
        word == "sessiontime")
      return &channel;
  }
  return nullptr;
}

/// Whether decimals have points or commas: in a log, all alike.
class Decimals {
 public:
  explicit Decimals(char separator) : separator_(separator) {}

  /// NaN where the cell is no finite number; `column` and `place` are for messages.
  double number(std::string_view cell, const std::string& column, const auto& place) {
    const auto found = base::number_between(cell, separator_);
    const double value =
        found && std::isfinite(*found) ? *found : std::numeric_limits<double>::quiet_NaN();
    if (std::isnan(value)) {
      if (is_number_with_commas(cell))
        throw base::Error(fmt::format(
            "{}: column '{:.40}' holds '{:.40}', wanted a number, a word or nothing; write "
            "numbers without separators of thousands",
            place(), column, cell));
      return value;
    }
    const std::size_t at = cell.find_first_of(",.");
    if (at == std::string_view::npos) return value;
    if (mark_ == 0) mark_ = cell[at];
    if (mark_ != cell[at])
      throw base::Error(fmt::format(
          "{}: column '{:.40}' holds '{:.40}', but other decimals of this table have '{}'; write "
          "all alike",
          place(), column, cell, mark_));
    return value;
  }

 private:
  char separator_;
  char mark_ = 0;  ///< once one was seen
};

/// Takes the cells of one column: dates with times, of the clock also times without dates, as
/// seconds from the first one on.
class ColumnReader {
 public:
  ColumnReader(Channel& channel, bool is_clock) : channel_(&channel), is_clock_(is_clock) {}

  void take(std::string_view cell, Decimals& decimals, const std::string& name, std::size_t line) {
    double value =
        decimals.number(cell, channel_->name, [&] { return fmt::format("{}:{}", name, line); });
    const bool counts = !std::isnan(value);
    const std::optional<IsoTime> time = counts || cell.empty() ? std::nullopt : moment(cell);
    const bool unlike =
        (counts && first_) || (time && counted_) ||
        (time && first_ && (time->zoned != first_->zoned || time->dated != first_->dated));
    if (unlike && is_clock_)
      throw base::Error(fmt::format(
          "{}:{}: column '{}' holds '{:.40}', unlike the rows above: seconds, times, dates with "
          "times, or dates with times and zones are wanted; write all alike",
          name, line, channel_->name.substr(0, 40), cell));
    counted_ = counted_ || (counts && !unlike);
    if (time && !unlike) {
      if (!first_) first_ = time;
      value =
          static_cast<double>(time->whole_s - first_->whole_s) + (time->part_s - first_->part_s);
      if (channel_->name != "time_s") channel_->unit = "s";
    } else if (unlike || (!counts && !cell.empty())) {
      ++channel_->words;
      value = std::numeric_limits<double>::quiet_NaN();
    }
    channel_->values.push_back(value);
  }

 private:
  std::optional<IsoTime> moment(std::string_view cell) {
    std::optional<IsoTime> time = iso_time(cell);
    if (time || !is_clock_) return time;
    time = time_of_day(cell);
    if (!time) return time;
    constexpr std::int64_t kDay_s = 86400;
    const std::int64_t step_s = time->whole_s - last_of_day_s_;
    if (step_s < -kDay_s / 2) midnights_s_ += kDay_s;
    if (step_s > kDay_s / 2 && midnights_s_ > 0) midnights_s_ -= kDay_s;  // a row that is late
    last_of_day_s_ = time->whole_s;
    time->whole_s += midnights_s_;
    return time;
  }

  Channel* channel_;
  bool is_clock_;  ///< else a cell unlike the others is a word
  std::optional<IsoTime> first_;
  bool counted_ = false;  ///< a number was there
  std::int64_t last_of_day_s_ = 0, midnights_s_ = 0;
};

void read_rows(std::string_view text, const Shape& shape, const std::string& name, Log& log) {
  base::Lines lines(text);
  std::string_view line;
  std::vector<std::string_view> cells;
  const Channel* const clock = clock_of(log);
  std::vector<ColumnReader> readers;
  for (Channel& channel : log.channels) readers.emplace_back(channel, &channel == clock);
  const std::size_t columns = readers.size();
  Decimals decimals(shape.separator);
  while (lines.next(line)) {
    const bool cut_off = lines.rest().empty() && text.find_last_of("\r\n") + 1 != text.size();
    if (lines.number() < shape.data_line) continue;
    const std::string_view inside = base::trimmed(line);
    if (inside.empty() || inside.front() == '#') continue;
    base::split_cells(shape.separator == '\t' ? line : inside, shape.separator, cells);
    while (cells.size() > columns && cells.back().empty()) cells.pop_back();
    if (cells.size() != columns) {
      if (cut_off && cells.size() < columns) break;  // the logger lost power
      throw base::Error(fmt::format("{}:{}: {} cells, the header names {} columns{}", name,
                                    lines.number(), cells.size(), columns,
                                    base::advice_on_length(cells, columns, shape.separator)));
    }
    for (std::size_t c = 0; c < columns; ++c)
      readers[c].take(cells[c], decimals, name, lines.number());
  }
}

}  // namespace

bool is_unit(std::string_view cell) {
  static const std::set<std::string, std::less<>> known{
      "s",     "ms",   "us",   "ns",  "m",      "km",    "mm",    "ft",    "deg",       "rad",
      "m/s",   "km/h", "kmh",  "kph", "mph",    "knots", "deg/s", "rad/s", "g",         "m/s2",
      "%",     "rpm",  "bar",  "kpa", "mbar",   "psi",   "c",     "v",     "unix time", "m/s/s",
      "m/s^2", "°",    "\xb0", "°/s", "\xb0/s", "1/min", "mpa",   "nm",    "n",         "k"};
  std::string lower;
  for (const char c : cell)
    if (c != '[' && c != ']' && c != '(' && c != ')')
      lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return known.contains(lower);
}

Log parse_csv(std::string_view text, const std::string& name) {
  text = base::behind_byte_order_mark(text, name);
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
  Log log{"CSV", {}, true};
  for (std::size_t c = 0; c < shape.names.size(); ++c) {
    Channel channel;
    channel.name = shape.names[c];
    if (c < shape.units.size()) channel.unit = shape.units[c];
    log.channels.push_back(std::move(channel));
  }
  if (text.size() / 2 > kMostCells * 2)
    throw base::Error(name + ": more than 2 GB of cells; cut the log");
  read_rows(text, shape, name, log);
  if (shape.exported) number_names(log.channels);
  if (const Channel* const clock = clock_of(log)) {
    std::vector<double> time_s = clock->values;
    const bool in_ms = clock->unit == "ms" || clock->name.find("ms") != std::string::npos;
    if (in_ms)
      for (double& t : time_s) t *= 1e-3;
    set_rates(log, time_s);
  }
  return log;
}

}  // namespace recording
