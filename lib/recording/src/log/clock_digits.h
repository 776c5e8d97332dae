// Clocks of plain numbers whose digits are no seconds, and clocks that begin again.
#pragma once

#include <string>
#include <vector>

#include "recording/log.h"

namespace recording {

/// 123059.5 becomes 45059.5: hours, minutes and seconds in one number become seconds of the day,
/// which go on over midnight.
void to_seconds_of_day(std::vector<double>& clock);

/// Brings the clock of a log to seconds where it has no unit and its digits are hours, minutes and
/// seconds, or days of a spreadsheet; and lets it run on where its counter begins again (16 and 32
/// bits, the day, the GPS week). Notes say what was done.
void mend_clock_digits(Channel& clock, std::vector<std::string>& notes);

}  // namespace recording
