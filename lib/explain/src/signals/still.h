#pragma once

#include "explain/signals.h"

namespace explain {

/// Whether the car gains or loses 8 m/s within 5 s against a throttle that stays where it is at
/// step `begin`: loses it with more than a third, gains it without any, or does both. Without any
/// it is enough to gain 1 m/s more than a slope of a tenth makes; so it is to gain and to lose so
/// much where the throttle stays between closed and open, and for no second anywhere else in the
/// drive.
bool moves_against_throttle(const Signals& signals, std::size_t begin, std::size_t end);

/// Takes out, with a remark, where a channel stands still while the others say that it moved:
/// positions for half a second, steering for two, the throttle for five, others for one; yaw rate
/// and lateral acceleration where the path does not turn as they say all along. A channel that
/// stands still for over a fifth of the drive is not used at all, and the recording is `broken`; so
/// it is by any other than positions that stands for over a twentieth.
/// Throws vehicle::Error where that channel is the position or the speed.
void leave_out_still(Signals& signals);

/// Takes positions out for 0.3 s around where the place leaps: the path is faster or slower than
/// the logged speed by 5 m/s and a fifth, or bends with over 100 m/s2 and far
/// more than positions jitter. Over a twentieth of the drive it is no leap: left as it is.
void leave_out_leaps(Signals& signals);

}  // namespace explain
