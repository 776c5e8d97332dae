// How the driver's feet move between the rows of a log.
#pragma once

#include "force_channels.h"

namespace identify {

/// Throttle and brakes move from row to row as the recorded channels do, as far as these move by
/// more than their noise over 0.06 s to either side; the variance of what they may move otherwise
/// is that of these moves. A foot without a channel only has the variance that it has.
void move_feet(const recording::Recording& recording, ForceChannels& out);

}  // namespace identify
