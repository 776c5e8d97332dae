// Logs as text: the cells behind the header.
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
#include "clock_digits.h"
#include "csv_shape.h"
#include "csv_words.h"
#include "iso_time.h"
#include "laps.h"
#include "readers.h"
#include "recording/look.h"

namespace recording {
namespace {

/// Whether a cell that is no number would be one without the separators of its thousands, or with a
/// point for a comma.
bool is_number_with_commas(std::string_view cell) {
  if (cell.find(',') == std::string_view::npos) return false;
  if (const auto value = base::number_with_comma(cell); value && std::isfinite(*value)) return true;
  if (cell.starts_with('-') || cell.starts_with('+')) cell.remove_prefix(1);
  for (bool first = true;; first = false) {
    const std::size_t digits = std::min(cell.find_first_not_of("0123456789"), cell.size());
    if (digits == cell.size()) return digits > 0;
    if ((cell[digits] != ',' && cell[digits] != '.') || digits > 3 || digits < (first ? 1 : 3))
      return false;
    cell.remove_prefix(digits + 1);
  }
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
          "all alike{}",
          place(), column, cell, mark_,
          cell[at] == ',' && cell.size() == at + 4 ? ", and without separators of thousands" : ""));
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
    const std::optional<IsoTime> time =
        counts || cell.empty() ? std::nullopt : moment(cell, name, line);
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
      value = std::numeric_limits<double>::quiet_NaN();
      if (unlike || !take_amount(cell, value)) ++channel_->words;
    }
    channel_->values.push_back(value);
  }

 private:
  /// "52.1 km/h" and "48.1234N"; the unit is the column's, in all rows.
  bool take_amount(std::string_view cell, double& value) {
    if (const std::optional<double> degrees = degrees_of(cell)) {
      value = *degrees;
      if (channel_->unit.empty()) channel_->unit = "deg";
      return channel_->unit == "deg";
    }
    const std::optional<Amount> amount = amount_of(cell);
    if (!amount || counted_) return false;
    if (channel_->unit.empty()) channel_->unit = std::string(amount->unit);
    if (channel_->unit == amount->unit) value = amount->value;
    return channel_->unit == amount->unit;
  }

  std::optional<IsoTime> moment(std::string_view cell, const std::string& name, std::size_t line) {
    if (is_clock_ && cell.starts_with('\''))
      cell.remove_prefix(1);  // a spreadsheet's mark of a text
    std::optional<IsoTime> time = iso_time(cell);
    if (time || !is_clock_) return time;
    if (const std::optional<IsoTime> duration = days_and_time(cell)) return duration;
    const std::string_view date = date_before_time(cell);
    time = time_of_day(cell.substr(date.empty() ? 0 : date.size() + 1));
    if (!time) return minutes_and_seconds(cell);
    constexpr std::int64_t kDay_s = 86400;
    const std::int64_t step_s = time->whole_s - last_of_day_s_;
    if (step_s < -kDay_s / 2) midnights_s_ += kDay_s;
    if (step_s > kDay_s / 2 && midnights_s_ > 0) midnights_s_ -= kDay_s;  // a row that is late
    // Which part of it is the day, the date does not say.
    const bool by_midnight = step_s < -kDay_s / 2 && step_s + kDay_s < 3600;
    if (date != date_ && first_ && !by_midnight)
      throw base::Error(fmt::format(
          "{}:{}: column '{:.40}' holds '{:.40}', another date without a midnight between; write "
          "dates with times as 2024-05-01T12:00:00.1Z",
          name, line, channel_->name, cell));
    date_ = date;
    last_of_day_s_ = time->whole_s;
    time->whole_s += midnights_s_;
    return time;
  }

  Channel* channel_;
  bool is_clock_;  ///< else a cell unlike the others is a word
  std::optional<IsoTime> first_;
  bool counted_ = false;  ///< a number was there
  std::int64_t last_of_day_s_ = 0, midnights_s_ = 0;
  std::string_view date_;  ///< of the row before, in whatever order
};

/// RaceCapture writes "AccelX"|"G"|-3.0|3.0|25: name, unit, least, greatest, samples a second.
void take_metadata(Channel& channel) {
  std::string_view rest = channel.name;
  const auto quoted = [&]() -> std::optional<std::string> {
    if (!rest.starts_with('"')) return std::nullopt;
    const std::size_t close = rest.find("\"|", 1);
    if (close == std::string_view::npos) return std::nullopt;
    std::string out(rest.substr(1, close - 1));
    rest.remove_prefix(close + 2);
    return out;
  };
  const std::optional<std::string> name = quoted();
  const std::optional<std::string> unit = name ? quoted() : std::nullopt;
  if (!unit || name->empty()) return;
  channel.unit = *unit;
  channel.name = *name;
}

Words read_rows(std::string_view text, const Shape& shape, const std::string& name, Log& log) {
  base::Lines lines(text);
  std::string_view line;
  std::vector<std::string_view> cells;
  const Channel* const clock = clock_of(log);
  std::vector<ColumnReader> readers;
  for (Channel& channel : log.channels) readers.emplace_back(channel, &channel == clock);
  const std::size_t columns = readers.size();
  Decimals decimals(shape.separator);
  const std::vector<bool> with_words = columns_with_words(log);
  Words words(columns);
  std::size_t marks = 0, heads = 0;
  while (lines.next(line)) {
    const bool cut_off = lines.rest().empty() && text.find_last_of("\r\n") + 1 != text.size();
    if (lines.number() < shape.data_line) continue;
    const std::string_view inside = base::trimmed(line);
    if (inside.empty() || inside.front() == '#') continue;
    base::split_cells(shape.separator == '\t' ? line : inside, shape.separator, cells);
    while (cells.size() > columns && cells.back().empty()) cells.pop_back();
    if (std::equal(cells.begin(), cells.end(), shape.names.begin(), shape.names.end())) {
      ++heads;  // a logger that was started again
      continue;
    }
    if (cells.size() != columns) {
      if (cut_off && cells.size() < columns) break;              // the logger lost power
      if (cells.size() == 1 && cells[0].starts_with("MARK ")) {  // MegaSquirt, between the rows
        ++marks;
        continue;
      }
      throw base::Error(fmt::format("{}:{}: {} cells, the header names {} columns{}", name,
                                    lines.number(), cells.size(), columns,
                                    base::advice_on_length(cells, columns, shape.separator)));
    }
    for (std::size_t c = 0; c < columns; ++c) {
      readers[c].take(cells[c], decimals, name, lines.number());
      if (with_words[c]) words[c].push_back(cells[c]);
    }
  }
  if (heads > 0)
    log.notes.push_back(fmt::format("{} lines that repeat the header are left out", heads));
  if (marks > 0) log.notes.push_back(fmt::format("{} lines of marks are left out", marks));
  return words;
}

}  // namespace

Log parse_csv(std::string_view text, const std::string& name) {
  text = base::behind_byte_order_mark(text, name);
  const Shape shape = shape_of(text, name);
  Log log{"CSV", {}, true};
  for (std::size_t c = 0; c < shape.names.size(); ++c) {
    Channel channel;
    channel.name = shape.names[c];
    if (c < shape.units.size()) channel.unit = shape.units[c];
    if (c < shape.sources.size() && !shape.sources[c].empty() &&
        std::count(shape.names.begin(), shape.names.end(), shape.names[c]) > 1)
      channel.name = shape.sources[c] + " " + shape.names[c];
    take_metadata(channel);
    log.channels.push_back(std::move(channel));
  }
  if (text.size() / 2 > kMostCells * 2)
    throw base::Error(name + ": more than 2 GB of cells; cut the log");
  const Words words = read_rows(text, shape, name, log);
  want_one_car(log, words, name);
  if (const Channel* const clock = clock_by_values(log); clock != nullptr)
    mend_clock_digits(log.channels[static_cast<std::size_t>(clock - log.channels.data())],
                      log.notes);
  mend_clock_by_columns(log);
  if (is_long_form(log)) return signals_of_long_form(std::move(log), words);
  give_signs_of_hemispheres(log, words);
  number_names(log.channels);
  if (const std::vector<double> time_s = clock_of_rows(log); !time_s.empty()) {
    set_rates(log, time_s);
    const double seen_s = std::max(0.0, time_s.back() - time_s.front());
    if (shape.stated_s > 1.1 * seen_s + 1.0)
      log.notes.push_back(fmt::format(
          "the head of the file states {:.1f} s, its rows end after {:.1f} s: laps and beacons "
          "behind them are not in it",
          shape.stated_s, seen_s));
    add_laps(log, shape.beacons_s, "the Beacon Markers in the head of the file");
  }
  return log;
}

}  // namespace recording
