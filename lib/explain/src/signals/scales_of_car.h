// Scales of columns against the car: road wheels stand in slow turns as the wheelbase asks; loads
// are those of its mass; pedals move it as they did before.
#pragma once

#include "explain/signals.h"
#include "vehicle/vehicle_file.h"

namespace explain {

/// Leaves out a measured steering that turns less than 0.7 times or more than 1.4 times what the
/// wheelbase asks in the path's bends, with what tyres add by lateral acceleration apart: a column
/// in another unit or of the steering wheel, or another car. Not where the log does not tell the
/// two apart.
void leave_out_other_steering(Signals& s, const vehicle::Vehicle& car);

/// The same of loads of all wheels, whose sum is less than 0.7 times or more than 1.7 times what
/// the stated weight and downforce make.
void leave_out_other_loads(Signals& s, const vehicle::Vehicle& car);

/// Leaves out a throttle or a pressure of the brakes that becomes 1.6 times as large or small for
/// what the car does at the same speed, and wheels that become 1.04 times as fast or slow for the
/// speed, and stay so.
void leave_out_what_changes(Signals& s);

}  // namespace explain
