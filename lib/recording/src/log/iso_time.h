// Dates with times as logs write them.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace recording {

/// A moment of the calendar, or of a day.
struct IsoTime {
  std::int64_t whole_s = 0;  ///< since the beginning of 1970 (UTC where zoned) or of the day
  double part_s = 0.0;       ///< from 0 to below 1
  bool zoned = false;        ///< whether Z or an offset from UTC stood there
  bool dated = true;         ///< whether a date stood there
};

/// A date and a time of ISO 8601 with T or one blank between, such as 2024-05-01T12:00:00.25+02:00;
/// seconds, their decimals, and Z or the offset may be left out. Nothing where the cell is none.
std::optional<IsoTime> iso_time(std::string_view cell);

/// A time without a date, such as 12:00:00.1, 9:30:05 or 12:59:50.5 PM.
std::optional<IsoTime> time_of_day(std::string_view cell);

/// Minutes, seconds and their decimals, such as 1:02.345.
std::optional<IsoTime> minutes_and_seconds(std::string_view cell);

/// "0 days 01:05:00.123", as a duration is written by pandas; nothing where it is none.
std::optional<IsoTime> days_and_time(std::string_view cell);

/// The date, in whatever order, of a cell such as "5/1/2024 12:00:00 PM", whose rest is a time of
/// day; empty: it is no such cell.
std::string_view date_before_time(std::string_view cell);

}  // namespace recording
