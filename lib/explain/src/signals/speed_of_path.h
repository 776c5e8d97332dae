// The logged speed against that of the path.
#pragma once

#include "explain/signals.h"

namespace explain {

/// Throws vehicle::Error where the speed is in another unit, or another channel, than the path's:
/// by its ratio to it, by a ratio that changes, or by more than any sensor of speed is off.
void refuse_another_unit(const Signals& s);

}  // namespace explain
