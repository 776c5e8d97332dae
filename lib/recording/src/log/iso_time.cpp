#include "iso_time.h"

#include <algorithm>
#include <cctype>
#include <chrono>

namespace recording {
namespace {

/// Takes one character of `any` from the front.
bool take_one(std::string_view& text, std::string_view any) {
  if (text.empty() || any.find(text.front()) == std::string_view::npos) return false;
  text.remove_prefix(1);
  return true;
}

/// Takes `count` digits from the front, as a number up to `most`.
bool take_digits(std::string_view& text, std::size_t count, int most, int& value) {
  if (text.size() < count) return false;
  value = 0;
  for (const char c : text.substr(0, count)) {
    if (c < '0' || c > '9') return false;
    value = 10 * value + (c - '0');
  }
  text.remove_prefix(count);
  return value <= most;
}

/// Takes decimals behind a point or a comma, if there are some.
bool take_part(std::string_view& text, double& part_s) {
  if (!take_one(text, ".,")) return true;
  const std::size_t count = std::min(text.find_first_not_of("0123456789"), text.size());
  double digits = 0.0, one = 1.0;  // exact up to 1e15, so that the decimals are as of a number
  for (const char c : text.substr(0, std::min<std::size_t>(count, 12))) {
    digits = 10.0 * digits + (c - '0');
    one *= 10.0;
  }
  part_s = digits / one;
  text.remove_prefix(count);
  return count > 0;
}

/// Takes Z or an offset, if there is one.
bool take_zone(std::string_view& text, IsoTime& time) {
  if (text.empty() || take_one(text, "Zz")) return true;
  const int sign = text.front() == '-' ? -1 : 1;
  int hours = 0, minutes = 0;
  if (!take_one(text, "+-") || !take_digits(text, 2, 23, hours)) return false;
  const bool colon = take_one(text, ":");
  if ((colon || !text.empty()) && !take_digits(text, 2, 59, minutes)) return false;
  time.whole_s -= std::int64_t{60} * sign * (60 * hours + minutes);
  return true;
}

}  // namespace

std::optional<IsoTime> iso_time(std::string_view cell) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;
  if (!take_digits(cell, 4, 9999, year) || !take_one(cell, "-") ||
      !take_digits(cell, 2, 12, month) || !take_one(cell, "-") || !take_digits(cell, 2, 31, day) ||
      !take_one(cell, "Tt ") || !take_digits(cell, 2, 23, hour) || !take_one(cell, ":") ||
      !take_digits(cell, 2, 59, minute))
    return std::nullopt;
  IsoTime time;
  if (take_one(cell, ":") &&
      (!take_digits(cell, 2, 60, second) || !take_part(cell, time.part_s)))  // 60: a leap second
    return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year{year},
                                         std::chrono::month{static_cast<unsigned>(month)},
                                         std::chrono::day{static_cast<unsigned>(day)}};
  if (!date.ok()) return std::nullopt;
  time.whole_s = std::chrono::sys_days{date}.time_since_epoch().count() * std::int64_t{86400} +
                 std::int64_t{60} * (60 * hour + minute) + second;
  time.zoned = !cell.empty();
  if (!take_zone(cell, time) || !cell.empty()) return std::nullopt;
  return time;
}

std::optional<IsoTime> time_of_day(std::string_view cell) {
  int hour = 0, minute = 0, second = 0;
  IsoTime time;
  time.dated = false;
  const std::size_t digits = cell.find(':') == 1 ? 1 : 2;
  if (!take_digits(cell, digits, 23, hour) || !take_one(cell, ":") ||
      !take_digits(cell, 2, 59, minute) || !take_one(cell, ":") ||
      !take_digits(cell, 2, 60, second) || !take_part(cell, time.part_s))
    return std::nullopt;
  (void)take_one(cell, " ");
  if (!cell.empty()) {
    const bool afternoon = take_one(cell, "Pp");
    if ((!afternoon && !take_one(cell, "Aa")) || !take_one(cell, "Mm") || hour < 1 || hour > 12)
      return std::nullopt;
    hour = hour % 12 + (afternoon ? 12 : 0);
  }
  if (!cell.empty()) return std::nullopt;
  time.whole_s = std::int64_t{60} * (60 * hour + minute) + second;
  return time;
}

std::optional<IsoTime> minutes_and_seconds(std::string_view cell) {
  int minute = 0, second = 0;
  IsoTime time;
  time.dated = false;
  const std::size_t digits = cell.find(':');
  if (digits < 1 || digits > 3 || !take_digits(cell, digits, 999, minute) || !take_one(cell, ":") ||
      !take_digits(cell, 2, 59, second) || cell.empty() || !take_part(cell, time.part_s) ||
      !cell.empty())
    return std::nullopt;
  time.whole_s = std::int64_t{60} * minute + second;
  return time;
}

std::optional<IsoTime> days_and_time(std::string_view cell) {
  const std::size_t digits = cell.find_first_not_of("0123456789");
  int days = 0;
  if (digits == std::string_view::npos || digits < 1 || digits > 5 ||
      !take_digits(cell, digits, 99999, days))
    return std::nullopt;
  for (const std::string_view word : {" days ", " day "}) {
    if (!cell.starts_with(word)) continue;
    std::optional<IsoTime> time = time_of_day(cell.substr(word.size()));
    if (time) time->whole_s += std::int64_t{86400} * days;
    return time;
  }
  return std::nullopt;
}

std::string_view date_before_time(std::string_view cell) {
  const std::size_t blank = cell.find(' ');
  if (blank < 6 || blank > 11) return {};
  const std::string_view date = cell.substr(0, blank);
  const auto fits = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '/' || c == '.' || c == '-';
  };
  const bool is_date = std::all_of(date.begin(), date.end(), fits) &&
                       date.find_first_of("0123456789") != std::string_view::npos &&
                       date.find_first_of("/.-") != std::string_view::npos;
  return is_date && time_of_day(cell.substr(blank + 1)) ? date : std::string_view{};
}

}  // namespace recording
