#pragma once

#include <map>
#include <utility>
#include <vector>

#include "explain/signals.h"

namespace explain {

/// Left and right of an axle's wheel speeds, loads or brake pressures, smoothed, beside the mean or
/// sum in Signals.
using Sides = std::map<Channel, std::pair<std::vector<double>, std::vector<double>>>;

/// In a turn the outer wheel rolls faster and is loaded more, and braking loads the front: axles of
/// which the opposite is logged are exchanged. An axle of which one wheel stands still or runs at
/// another speed for over a twentieth of the drive is not used, nor one of which a column stands
/// where the other goes on, nor loads in another unit. A remark says which column.
void leave_out_exchanged(Signals& signals, const Sides& sides);

}  // namespace explain
