#include "recording/look.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <limits>
#include <utility>

#include "base/letters.h"
#include "base/parallel.h"
#include "base/statistics.h"
#include "readers.h"

namespace recording {

namespace {

/// The name in lower case without punctuation and without a unit in brackets.
std::string clock_word(std::string name) {
  if (name.starts_with("m_")) name.erase(0, 2);  // a variable of a program
  return base::letters_and_digits_of(name.substr(0, name.find_first_of("[(", 1)));
}

bool is_clock(const std::string& word) {
  for (const char* name :
       {"time",       "times",       "timems",  "t",           "ts",      "timestamp",
        "zeit",       "zeitstempel", "xtime",   "sessiontime", "logtime", "elapsedtime",
        "devicetime", "unixtime",    "utctime", "timeutc",     "tow",     "tows",
        "gpstow",     "gpstows",     "itow",    "timestamps",  "runtime"})
    if (word == name) return true;
  return false;
}

/// "time_of_day", "utc (ms)", "INS_time_sec"; a date alone is none. The last are of single loggers.
bool may_be_clock(const std::string& word) {
  for (const char* name : {"seconds", "secondselapsed", "interval", "offset", "cts", "rectime"})
    if (word == name) return true;
  return word.find("date") == std::string::npos &&
         (word.starts_with("time") || word.starts_with("zeit") || word.starts_with("utc") ||
          word.ends_with("timesec") || word.ends_with("timestamp"));
}

/// Between samples that are numbers and have a moment; a clock that runs backwards makes no gap.
double longest_gap_s(const std::vector<double>& values, const std::vector<double>& time_s) {
  double longest = 0.0, last = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 0; k < std::min(values.size(), time_s.size()); ++k) {
    if (!std::isfinite(values[k]) || !std::isfinite(time_s[k])) continue;
    if (time_s[k] - last > longest) longest = time_s[k] - last;
    last = time_s[k];
  }
  return longest;
}

/// "CLT (°C)": °C; nothing where what stands in brackets is no unit.
std::string unit_in_name(const std::string& name) {
  const std::size_t open = name.find_last_of("[(");
  if (open == std::string::npos || name.find_first_of("])", open) + 1 != name.size()) return {};
  const std::string unit = name.substr(open + 1, name.size() - open - 2);
  return is_unit(unit) ? unit : std::string();
}

}  // namespace

const Channel* clock_of(const Log& log) {
  for (const auto& called : {is_clock, may_be_clock})
    for (const Channel& channel : log.channels)
      if (called(clock_word(channel.name))) return &channel;
  return nullptr;
}

namespace {

/// Whether nine in ten of the samples are later than the one before.
bool runs(const std::vector<double>& values) {
  std::size_t forward = 0, steps = 0;
  double last = std::numeric_limits<double>::quiet_NaN();
  for (const double t : values) {
    if (!std::isfinite(t)) continue;
    steps += std::isfinite(last) ? 1 : 0;
    forward += t > last ? 1 : 0;
    last = t;
  }
  return steps >= 2 && 10 * forward >= 9 * steps;
}

}  // namespace

bool is_time_that_runs(const std::string& name, const std::vector<double>& values) {
  const std::string word = clock_word(name);
  const bool is_called_time =
      word.find("time") != std::string::npos || word.ends_with("zeit") || word.ends_with("tempo");
  Channel column;
  column.name = name;
  // What stands in brackets is a unit, or says which time it is: "Dwell time [deg]".
  const bool is_plain = name.find_first_of("[(", 1) == std::string::npos;
  return ((is_called_time && is_plain) || stated_scale(column)) && runs(values);
}

bool is_finer_clock(const std::string& name, const std::vector<double>& values,
                    const std::vector<double>& coarse) {
  const std::string word = clock_word(name);
  if (!is_clock(word) && !may_be_clock(word)) return false;
  // A time in the lap begins anew.
  const bool goes_back =
      std::adjacent_find(values.begin(), values.end(), std::greater<>()) != values.end();
  return !goes_back && share_held(coarse) > 0.5 && runs(values);
}

const Channel* clock_by_values(const Log& log) {
  if (const Channel* const called = clock_of(log)) {
    for (const Channel& channel : log.channels)
      if (is_finer_clock(channel.name, channel.values, called->values)) return &channel;
    return called;
  }
  for (const Channel& channel : log.channels)
    if (is_time_that_runs(
            channel.unit.empty() ? channel.name : channel.name + " [" + channel.unit + "]",
            channel.values))
      return &channel;
  return nullptr;
}

double scale_of_moments(const std::vector<double>& moments) {
  double largest = 0.0;
  bool whole = true;
  std::vector<double> steps;
  for (std::size_t i = 0; i < moments.size(); ++i) {
    if (!std::isfinite(moments[i])) continue;
    largest = std::max(largest, std::abs(moments[i]));
    whole = whole && moments[i] == std::floor(moments[i]);
    if (i > 0 && moments[i] > moments[i - 1]) steps.push_back(moments[i] - moments[i - 1]);
  }
  if (largest > 6e17) return 1e-9;
  if (largest > 6e14) return 1e-6;
  if (largest > 6e11) return 1e-3;
  const bool since_1970 = !whole && largest > 6e8;  // in seconds, however far apart
  if (since_1970 || steps.empty()) return 1.0;
  const double step = base::median(std::move(steps));
  // No logger writes a row every five seconds.
  return step < 5.0 ? 1.0 : step < 5e3 ? 1e-3 : step < 5e6 ? 1e-6 : 1e-9;
}

std::optional<double> stated_scale(const Channel& clock) {
  for (const auto& [unit, scale] :
       std::initializer_list<std::pair<std::string, double>>{{"s", 1.0},
                                                             {"sec", 1.0},
                                                             {"seconds", 1.0},
                                                             {"ms", 1e-3},
                                                             {"us", 1e-6},
                                                             {"ns", 1e-9},
                                                             {"msec", 1e-3},
                                                             {"usec", 1e-6},
                                                             {"nsec", 1e-9},
                                                             {"min", 60.0},
                                                             {"h", 3600.0}})
    if (clock.unit == unit || clock.name.ends_with("_" + unit) ||
        clock.name.find("(" + unit + ")") != std::string::npos ||
        clock.name.find("[" + unit + "]") != std::string::npos)
      return scale;
  const std::string word = clock_word(clock.name);
  if (word == "timestampms" || word == "cts") return 1e-3;
  if (word == "seconds" || word == "secondselapsed") return 1.0;
  return std::nullopt;
}

std::vector<double> clock_of_rows(const Log& log) {
  const Channel* const clock = clock_by_values(log);
  if (clock == nullptr) return {};
  std::vector<double> time_s = clock->values;
  const std::optional<double> stated = stated_scale(*clock);
  const double scale = stated ? *stated : scale_of_moments(time_s);
  for (double& t : time_s) t *= scale;
  return time_s;
}

double share_held(const std::vector<double>& values) {
  std::size_t same = 0, seen = 0, run = 0, longest = 0;
  double last = std::numeric_limits<double>::quiet_NaN();
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    ++seen;
    run = value == last ? run + 1 : 0;
    same += value == last ? 1 : 0;
    longest = std::max(longest, run);
    last = value;
  }
  return seen <= longest + 20
             ? 0.0
             : static_cast<double>(same - longest) / static_cast<double>(seen - longest);
}

bool is_dead(const std::vector<double>& values) {
  constexpr std::size_t kEnough = 50;
  double first = std::numeric_limits<double>::quiet_NaN();
  std::size_t seen = 0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    if (seen++ == 0) first = value;
    if (value != first) return false;
  }
  return seen >= kEnough;
}

std::vector<double> moments_of(const Log& log, const Channel& channel) {
  if (log.in_rows) return clock_of_rows(log);
  if (!log.clocks.empty()) return log.clocks.at(channel.clock);
  std::vector<double> out;
  if (channel.rate_hz > 0.0)
    for (std::size_t k = 0; k < channel.values.size(); ++k)
      out.push_back(static_cast<double>(k) / channel.rate_hz);
  return out;
}

std::vector<ChannelLook> look_at_channels(const Log& log) {
  std::vector<ChannelLook> out(log.channels.size());
  const std::vector<double> rows_s =
      log.in_rows ? clock_of_rows(log) : std::vector<double>{};  // of all channels
  base::parallel_for(out.size(), 1, 0, [&](std::size_t c, std::size_t) {
    const Channel& channel = log.channels[c];
    ChannelLook& look = out[c];
    look = {.name = channel.name,
            .unit = channel.unit.empty() ? unit_in_name(channel.name) : channel.unit,
            .rate_hz = channel.rate_hz,
            .words = channel.words,
            .held = share_held(channel.values),
            .dead = is_dead(channel.values)};
    for (const double value : channel.values) {
      if (!std::isfinite(value)) continue;
      look.least = look.samples == 0 ? value : std::min(look.least, value);
      look.greatest = look.samples == 0 ? value : std::max(look.greatest, value);
      ++look.samples;
    }
    look.longest_gap_s =
        longest_gap_s(channel.values, log.in_rows ? rows_s : moments_of(log, channel));
  });
  return out;
}

}  // namespace recording
