#pragma once

#include "explain/signals.h"

namespace explain {

/// Takes out, with a remark, where a channel stands still while the others say that it moved:
/// positions for half a second, others for a second. A channel that stands still for over a fifth
/// of the drive is not used at all, and the recording is `broken`. Throws vehicle::Error where that
/// channel is the position or the speed.
void leave_out_still(Signals& signals);

/// Takes positions out for 0.3 s around where the place leaps: the path is faster or slower than
/// the logged speed by 5 m/s and a fifth, or bends with over 100 m/s2 and far
/// more than positions jitter. Over a twentieth of the drive it is no leap: left as it is.
void leave_out_leaps(Signals& signals);

}  // namespace explain
