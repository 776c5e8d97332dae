// Logs whose channels have rates of their own, on one clock.
#pragma once

#include "vehicle/recording.h"

namespace identify {

/// The recording with empty cells filled where the channel's own samples before and behind are at
/// most `longest_s` apart and no gap of the rows lies between: by the straight line, the gear as
/// before. Longer gaps stay empty.
vehicle::Recording without_short_gaps(vehicle::Recording recording, double longest_s = 0.25);

}  // namespace identify
