// Laps by beacons: from the preamble of an export, or from the .ldx beside a .ld.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "recording/log.h"

namespace recording {

/// Adds the laps of the .ldx beside a log, by add_laps(). Moments that are no numbers end in a note
/// of the log.
void add_laps_of_ldx(Log& log, std::string_view text, const std::string& name);

/// Adds the channel "beacon lap", which counts from 1 and goes on behind each beacon, and says in a
/// note whose beacons these are. Beacons behind the last sample are left out; without any other, or
/// with a channel of that name, the log stays as it is.
void add_laps(Log& log, const std::vector<double>& beacons_s, const std::string& from);

}  // namespace recording
