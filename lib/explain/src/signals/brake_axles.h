#pragma once

#include "explain/signals.h"
#include "vehicle/vehicle_file.h"

namespace explain {

/// The axle with the higher pressure slips more under braking, by what the car's brakes make of it:
/// where the wheels say that the pressures of front and rear are exchanged they are not used, with
/// a remark, and the recording is `broken`. Pressures that differ by less than a fifth are the same
/// exchanged.
void leave_out_exchanged_brakes(Signals& signals, const vehicle::Vehicle& car);

}  // namespace explain
