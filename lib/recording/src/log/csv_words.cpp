#include "csv_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <set>

#include "base/error.h"
#include "base/letters.h"
#include "base/statistics.h"
#include "base/text_lines.h"
#include "readers.h"
#include "recording/look.h"

namespace recording {
namespace {

/// The column with one of these names; the number of columns: none has.
std::size_t column_called(const Log& log, std::initializer_list<const char*> names) {
  for (std::size_t c = 0; c < log.channels.size(); ++c)
    for (const char* name : names)
      if (base::letters_of(log.channels[c].name) == name) return c;
  return log.channels.size();
}

std::size_t names_of_signals(const Log& log) {
  return column_called(log, {"signal", "signalname", "telemetryname", "channelname", "parameter",
                             "parametername", "name", "channel", "pid"});
}
std::size_t values_of_signals(const Log& log) {
  return column_called(log,
                       {"value", "signalvalue", "telemetryvalue", "physicalvalue", "channelvalue"});
}
std::size_t units_of_signals(const Log& log) { return column_called(log, {"unit", "units"}); }

/// A channel that says which car, or which driver's, a row is of.
bool says_car(const Channel& channel) {
  const std::string letters = base::letters_of(channel.name);
  for (const char* word :
       {"vehicle", "vehicleid", "vehiclenumber", "vehiclename", "vin", "originalvehicleid", "car",
        "carnumber", "carid", "driver", "drivernumber", "driverid"})
    if (letters == word) return true;
  return false;
}

bool is_on_earth(const Channel& channel) {
  const std::string letters = base::letters_of(channel.name);
  for (const char* word : {"lat", "latitude", "lon", "long", "lng", "longitude", "longtitude"})
    if (letters == word || letters == std::string("gps") + word ||
        letters == std::string(word) + "deg")
      return true;
  return false;
}

/// -1 in the south and the west, 1 in the north and the east; 0: no such letter.
double sign_of(std::string_view cell) {
  if (cell == "S" || cell == "s" || cell == "W" || cell == "w") return -1.0;
  return cell == "N" || cell == "n" || cell == "E" || cell == "e" ? 1.0 : 0.0;
}

}  // namespace

std::optional<Amount> amount_of(std::string_view cell) {
  const std::size_t blank = cell.find(' ');
  if (blank == std::string_view::npos || blank == 0) return std::nullopt;
  const std::string_view unit = base::trimmed(cell.substr(blank));
  const auto value = base::to_number<double>(cell.substr(0, blank));
  if (!value || !std::isfinite(*value) || !is_unit(unit)) return std::nullopt;
  return Amount{*value, unit};
}

std::optional<double> degrees_of(std::string_view cell) {
  if (cell.size() < 6 || cell.find('.') == std::string_view::npos) return std::nullopt;
  const double sign = sign_of(cell.substr(cell.size() - 1));
  const auto value = base::to_number<double>(cell.substr(0, cell.size() - 1));
  if (sign == 0.0 || !value || !(*value >= 0.0) || *value > 360.0) return std::nullopt;
  return sign * *value;
}

namespace {

bool are_whole(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return v == std::floor(v); });
}

void add_milliseconds(Log& log, Channel& clock) {
  const std::size_t at = column_called(log, {"ms", "millis", "millisecond", "milliseconds"});
  if (at == log.channels.size() || clock.unit != "s" || !are_whole(clock.values)) return;
  const std::vector<double>& ms = log.channels[at].values;
  if (&log.channels[at] == &clock || !are_whole(ms) ||
      std::any_of(ms.begin(), ms.end(), [](double v) { return v < 0.0 || v > 999.0; }))
    return;
  for (std::size_t i = 0; i < ms.size(); ++i) clock.values[i] += 1e-3 * ms[i];
  log.notes.push_back(
      fmt::format("'{}': with the milliseconds of '{}'", clock.name, log.channels[at].name));
}

/// Rows by the second in which they were written: a second has about as many as the others.
void spread_over_seconds(Log& log, Channel& clock) {
  std::vector<double>& t = clock.values;
  if (!are_whole(t)) return;
  std::vector<std::size_t> begins;  // of the rows of one second
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (i > 0 && t[i] != t[i - 1] && t[i] != t[i - 1] + 1.0) return;
    if (i == 0 || t[i] != t[i - 1]) begins.push_back(i);
  }
  constexpr std::size_t kFewestSeconds = 4, kFewestRows = 3;
  if (begins.size() < kFewestSeconds) return;
  std::vector<double> counts;  // of whole seconds, not of the first and the last one
  for (std::size_t k = 1; k + 1 < begins.size(); ++k)
    counts.push_back(static_cast<double>(begins[k + 1] - begins[k]));
  const double usual = base::median(counts);
  if (usual < static_cast<double>(kFewestRows)) return;
  for (const double count : counts)
    if (count < 0.5 * usual || count > 2.0 * usual) return;
  begins.push_back(t.size());
  for (std::size_t k = 0; k + 1 < begins.size(); ++k) {
    const double count = static_cast<double>(begins[k + 1] - begins[k]);
    const bool whole = k > 0 && k + 2 < begins.size();
    const double step = 1.0 / (whole ? count : std::max(count, usual));
    const double before = k == 0 ? 1.0 - count * step : 0.0;  // the first second ends with its rows
    for (std::size_t i = begins[k]; i < begins[k + 1]; ++i)
      t[i] += before + static_cast<double>(i - begins[k]) * step;
  }
  log.notes.push_back(
      fmt::format("'{}': whole seconds with about {:.0f} rows each, which are spread evenly: right "
                  "within a second",
                  clock.name, usual));
}

void go_on_over_laps(Log& log, Channel& clock) {
  const std::size_t at = column_called(log, {"lap", "laps", "lapnumber", "lapindex", "currentlap"});
  if (at == log.channels.size()) return;
  const std::vector<double>& laps = log.channels[at].values;
  std::vector<double>& t = clock.values;
  std::vector<double> shifts(t.size(), 0.0);
  double shift = 0.0;
  std::size_t times = 0;
  for (std::size_t i = 1; i < t.size(); ++i) {
    if (t[i] < t[i - 1]) {
      // Back to the lap's first moments, where the lap is another one, and at no other row.
      const double step = i > 1 ? t[i - 1] - t[i - 2] : 0.0;
      if (!(laps[i] == laps[i - 1] + 1.0) || !(step > 0.0) || !(std::abs(t[i]) < 3.0 * step))
        return;
      shift += t[i - 1] - t[i] + step;
      ++times;
    }
    shifts[i] = shift;
  }
  if (times == 0) return;
  for (std::size_t i = 0; i < t.size(); ++i) t[i] += shifts[i];
  log.notes.push_back(
      fmt::format("'{}': it begins again with each lap of '{}', {} times, and is read as going on",
                  clock.name, log.channels[at].name, times));
}

}  // namespace

void mend_clock_by_columns(Log& log) {
  const Channel* const found = clock_by_values(log);
  if (found == nullptr || is_long_form(log)) return;
  Channel& clock = log.channels[static_cast<std::size_t>(found - log.channels.data())];
  add_milliseconds(log, clock);
  if (clock.unit == "s") spread_over_seconds(log, clock);
  go_on_over_laps(log, clock);
}

bool is_long_form(const Log& log) {
  return names_of_signals(log) < log.channels.size() &&
         values_of_signals(log) < log.channels.size() && clock_of(log) != nullptr;
}

std::vector<bool> columns_with_words(const Log& log) {
  std::vector<bool> out(log.channels.size(), false);
  const bool is_long = is_long_form(log);
  const std::size_t names = names_of_signals(log), units = units_of_signals(log);
  for (std::size_t c = 0; c < out.size(); ++c)
    out[c] = says_car(log.channels[c]) ||
             (is_long ? c == names || c == units : c > 0 && is_on_earth(log.channels[c - 1]));
  return out;
}

void want_one_car(const Log& log, const Words& words, const std::string& name) {
  const std::vector<double> time_s = clock_of_rows(log);
  for (std::size_t c = 0; c < words.size(); ++c) {
    if (words[c].empty() || !says_car(log.channels[c])) continue;
    std::set<std::string_view> cars(words[c].begin(), words[c].end());
    cars.erase("");
    // Drivers may take turns in one car.
    const bool turns = base::letters_of(log.channels[c].name).starts_with("driver") &&
                       std::is_sorted(time_s.begin(), time_s.end());
    if (cars.size() > 1 && !turns)
      throw base::Error(fmt::format(
          "{}: rows of {} cars, by column '{}' ('{:.40}', '{:.40}' ...); write the rows of one car",
          name, cars.size(), log.channels[c].name, *cars.begin(), *std::next(cars.begin())));
  }
}

void give_signs_of_hemispheres(Log& log, const Words& words) {
  for (std::size_t c = 1; c < words.size(); ++c) {
    const auto says = [](std::string_view cell) { return cell.empty() || sign_of(cell) != 0.0; };
    if (words[c].empty() || !std::all_of(words[c].begin(), words[c].end(), says)) continue;
    std::vector<double>& values = log.channels[c - 1].values;
    bool turned = false;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (sign_of(words[c][i]) < 0.0) {
        values[i] = -std::abs(values[i]);
        turned = true;
      }
    if (turned)
      log.notes.push_back(fmt::format("'{}': south and west are negative, by the letters of '{}'",
                                      log.channels[c - 1].name, log.channels[c].name));
  }
}

namespace {

/// Latitudes and longitudes that stand beside the samples of every signal: channels of their own,
/// where the next moment has another place.
void add_places_of_rows(const Log& log, const std::vector<double>& time_s, double first_s,
                        Log& out) {
  for (const Channel& place : log.channels) {
    if (!is_on_earth(place)) continue;
    Channel channel;
    channel.name = place.name;
    channel.unit = place.unit;
    channel.clock = out.clocks.size();
    std::vector<double>& clock = out.clocks.emplace_back();
    for (std::size_t i = 0; i < place.values.size(); ++i) {
      const double t = time_s[i] - first_s;
      if (std::isnan(t) || std::isnan(place.values[i])) continue;
      if (!clock.empty() && (t <= clock.back() || place.values[i] == channel.values.back()))
        continue;
      clock.push_back(t);
      channel.values.push_back(place.values[i]);
    }
    out.channels.push_back(std::move(channel));
  }
}

}  // namespace

Log signals_of_long_form(Log log, const Words& words) {
  const std::vector<double> time_s = clock_of_rows(log);
  const std::vector<double>& values = log.channels[values_of_signals(log)].values;
  const std::vector<std::string_view>& names = words[names_of_signals(log)];
  const std::size_t units = units_of_signals(log);
  double first_s = std::nan("");
  for (const double t : time_s)
    if (std::isfinite(t) && !(t >= first_s)) first_s = t;
  Log out{"CSV, one row for each sample of a signal", {}, false, {}, std::move(log.notes)};
  std::map<std::string_view, std::size_t> at;
  std::size_t left_out = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto [found, fresh] = at.emplace(names[i], out.channels.size());
    if (fresh) {
      Channel& channel = out.channels.emplace_back();
      channel.name = std::string(names[i]);
      if (units < log.channels.size()) channel.unit = std::string(words[units][i]);
      channel.clock = out.clocks.size();
      out.clocks.emplace_back();
    }
    std::vector<double>& clock = out.clocks[found->second];
    const double t = time_s[i] - first_s;
    if (std::isnan(t) || std::isnan(values[i]) || (!clock.empty() && t <= clock.back())) {
      ++left_out;
      continue;
    }
    clock.push_back(t);
    out.channels[found->second].values.push_back(values[i]);
  }
  add_places_of_rows(log, time_s, first_s, out);
  if (left_out > 0)
    out.notes.push_back(
        fmt::format("{} of {} rows are left out: no number, no moment, or not later than the "
                    "sample before of the same signal",
                    left_out, names.size()));
  for (Channel& channel : out.channels) {
    const std::vector<double>& clock = out.clocks[channel.clock];
    if (clock.size() > 1)
      channel.rate_hz = static_cast<double>(clock.size() - 1) / (clock.back() - clock.front());
  }
  number_names(out.channels);
  return out;
}

}  // namespace recording
