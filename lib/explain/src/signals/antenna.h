#pragma once

#include "explain/signals.h"

namespace explain {

/// Where positions are those of a point beside the one whose speed is logged, the path is slower
/// than the speed in turns to that side and faster in others: from 1 m on a remark says by how
/// much, and the recording is `broken`, for what it would be taken for is banking.
void doubt_antenna_aside(Signals& signals);

}  // namespace explain
