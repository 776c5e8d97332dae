// What the channels of a log are like, before anything is known of what they mean.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "recording/log.h"

namespace recording {

/// One channel, as logged.
struct ChannelLook {
  std::string name, unit;   ///< as the file has them, "RPM [rpm]" says one, too; may be empty
  double rate_hz = 0.0;     ///< 0: the file has no clock
  std::size_t samples = 0;  ///< that are numbers
  std::size_t words = 0;    ///< cells that were none
  double least = 0.0, greatest = 0.0;  ///< 0 where there are no samples
  double held = 0.0;                   ///< share_held() of its values
  bool dead = false;                   ///< is_dead() of its values
  /// The longest time between two samples that are numbers; 0: the file has no clock.
  double longest_gap_s = 0.0;
};

std::vector<ChannelLook> look_at_channels(const Log& log);

/// The moments of a channel's samples, s, one for each; empty where the file has no clock.
std::vector<double> moments_of(const Log& log, const Channel& channel);

/// Whether a column that is called a clock tells rows apart of which another one, `coarse`, has
/// half or more at the moment of the row before: its digits are too few.
bool is_finer_clock(const std::string& name, const std::vector<double>& values,
                    const std::vector<double>& coarse);

/// Share of the samples that repeat the one before exactly; NaN is skipped. The longest run of them
/// does not count: a column that stands still from some time on is broken, not sampled and held. 0
/// where hardly anything else is left.
double share_held(const std::vector<double>& values);

/// One value in all of 50 samples or more.
bool is_dead(const std::vector<double>& values);

/// Seconds per unit of moments whose unit is not named. By the largest: of years 1990 to 2100 or
/// so, counted from 1970 in nanoseconds, microseconds or milliseconds, or with decimals in seconds.
/// By the usual step: from 5 on they are milliseconds, from 5,000 on microseconds, from 5e6 on
/// nanoseconds. Else 1.
double scale_of_moments(const std::vector<double>& moments);

/// Seconds per unit of a clock whose unit is given, or stands in its name.
std::optional<double> stated_scale(const Channel& clock);

/// Whether a column is a clock though it is not called one: "Section Time [s]", "auxTime",
/// "laptime_ms". It is called a time or has a unit of time, and goes forward in 9 of 10 rows; where
/// it begins again, as times of laps do, is for the reader of the drive.
bool is_time_that_runs(const std::string& name, const std::vector<double>& values);

/// The moments of a log in rows, s, from the channel that is called a clock, else from one with
/// is_time_that_runs(); empty where none is.
std::vector<double> clock_of_rows(const Log& log);

}  // namespace recording
