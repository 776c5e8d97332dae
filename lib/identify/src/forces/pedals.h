// The driver's feet: between the rows of a log, and at stops where a logger cut the noise off.
#pragma once

#include <vector>

#include "force_channels.h"

namespace identify {

/// Throttle and brakes move from row to row as the recorded channels do, as far as these move by
/// more than their noise over 0.06 s to either side; the variance of what they may move otherwise
/// is that of these moves. A foot without a channel only has the variance that it has.
void move_feet(const recording::Recording& recording, ForceChannels& out);

struct AtStop {
  std::vector<bool> row;
  double noise = 0.0;  ///< standard deviation by these rows; 0: there are none
};

/// Which rows of a channel that cannot pass `stop` (a released brake's 0, a closed or an open
/// throttle) show the stop and noise, of which the half beyond it is cut off: their mean is no
/// pressure. Rows between two that are exactly at the stop and at most 0.15 s apart, when at least
/// a fifth of all rows at rest are such rows; none of a channel without noise. Rows further from
/// the stop than four times that noise are none of them.
AtStop at_stop(const std::vector<double>& time_s, const std::vector<double>& values, double stop);

}  // namespace identify
