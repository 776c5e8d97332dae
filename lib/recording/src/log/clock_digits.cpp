#include "clock_digits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/statistics.h"
#include "recording/look.h"

namespace recording {
namespace {

constexpr double kDay_s = 86400.0;

double seconds_of_digits(double digits) {
  const double hours = std::floor(digits / 1e4), minutes = std::floor((digits - hours * 1e4) / 100);
  return hours * 3600.0 + minutes * 60.0 + (digits - hours * 1e4 - minutes * 100.0);
}

/// The usual step of a clock where it goes forward; 0: it never does.
double usual_step(const std::vector<double>& clock) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < clock.size(); ++i)
    if (clock[i] > clock[i - 1]) steps.push_back(clock[i] - clock[i - 1]);
  return steps.empty() ? 0.0 : base::median(std::move(steps));
}

/// Whether no number has more than 59 in its minutes or seconds, and a minute ends somewhere: by a
/// jump of 40 and a step. Seconds in steps this short would show 60 to 99.
bool is_hours_in_digits(const std::vector<double>& clock, double step) {
  constexpr double kLongestStep = 10.0;
  if (step > kLongestStep) return false;
  bool minute = false;
  double last = std::nan("");
  for (const double t : clock) {
    if (!std::isfinite(t)) continue;
    if (t < 0.0 || t >= 240000.0 || std::fmod(t, 100.0) >= 60.0 || std::fmod(t, 1e4) >= 6000.0)
      return false;
    double jump_s = seconds_of_digits(t) - seconds_of_digits(last);
    if (jump_s < 0.0) jump_s += kDay_s;
    minute = minute || (std::abs(t - last) >= 40.0 && jump_s > 0.0 && jump_s < 3.0 * step);
    last = t;
  }
  return minute;
}

bool is_days_of_spreadsheet(const std::vector<double>& clock, double step) {
  constexpr double kFirst = 20000.0, kLast = 80000.0;  // of 1954 and 2119, counted from 1900
  return step > 0.0 && step < 5.0 / kDay_s && std::all_of(clock.begin(), clock.end(), [](double t) {
           return std::isnan(t) || (t > kFirst && t < kLast);
         });
}

/// How often the counter began again, each time going on by the usual step.
std::size_t run_on(std::vector<double>& clock, double step) {
  // Milliseconds of 16 and 32 bits, microseconds of 32 bits, seconds of the day and of the week,
  // in s, ms and us.
  constexpr double kCounters[] = {65.536, 4294.967296, 4294967.296, kDay_s, 7 * kDay_s};
  std::size_t times = 0;
  double shift = 0.0, last = std::nan("");
  for (double& t : clock) {
    if (!std::isfinite(t)) continue;
    t += shift;
    if (t < last)
      for (const double scale : {1.0, 1e3, 1e6})
        for (const double counter : kCounters) {
          const double ahead = t + scale * counter - last;
          if (t >= last || !(ahead > 0.0 && ahead < 3.0 * step)) continue;
          shift += scale * counter;
          t += scale * counter;
          ++times;
        }
    last = t;
  }
  return times;
}

}  // namespace

void to_seconds_of_day(std::vector<double>& clock) {
  double days_s = 0.0, last = 0.0;
  for (double& t : clock) {
    t = seconds_of_digits(t);
    if (!std::isfinite(t)) continue;
    if (t + days_s < last - kDay_s / 2) days_s += kDay_s;
    last = t += days_s;
  }
}

void mend_clock_digits(Channel& clock, std::vector<std::string>& notes) {
  const double step = usual_step(clock.values);
  const bool is_open = clock.unit.empty() && !stated_scale(clock);
  if (is_open && is_hours_in_digits(clock.values, step)) {
    to_seconds_of_day(clock.values);
    clock.unit = "s";
    notes.push_back(fmt::format(
        "'{}': hours, minutes and seconds in one number, read as seconds of the day", clock.name));
  } else if (is_open && is_days_of_spreadsheet(clock.values, step)) {
    for (double& t : clock.values) t *= kDay_s;
    clock.unit = "s";
    notes.push_back(fmt::format("'{}': days of a spreadsheet, read as seconds", clock.name));
  } else if (const double scale = scale_of_moments(clock.values); is_open && scale < 1.0) {
    notes.push_back(fmt::format(
        "'{}': no unit is known, read as {}; where it is seconds, call it time_s", clock.name,
        scale == 1e-3   ? "ms"
        : scale == 1e-6 ? "us"
                        : "ns"));
  }
  if (const std::size_t times = run_on(clock.values, usual_step(clock.values)); times > 0)
    notes.push_back(fmt::format("'{}': its counter begins again {} times, and is read as going on",
                                clock.name, times));
}

}  // namespace recording
