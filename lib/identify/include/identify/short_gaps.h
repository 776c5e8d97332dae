// Logs whose channels have rates of their own, on one clock.
#pragma once

#include "recording/recording.h"

namespace identify {

/// The recording with empty cells filled where the channel's own samples before and behind are at
/// most `longest_s` apart and no gap of the rows lies between: by the straight line, the gear as
/// before. Longer gaps stay empty.
recording::Recording without_short_gaps(recording::Recording recording, double longest_s = 0.25);

}  // namespace identify
