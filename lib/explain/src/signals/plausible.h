#pragma once

#include "explain/signals.h"

namespace explain {

/// Compares every channel with what the path itself says of it (speed, yaw rate, accelerations,
/// curvature) and leaves out, with a remark that names unit, sign, clock or another column, what
/// cannot be that channel. Bounds: half as large again either way, 0.5 s, correlation 0.7 (0.5 for
/// steering and pedals).
void leave_out_implausible(Signals& signals);

/// What is driven this often shows what comes back every lap.
inline constexpr double kTwoRounds = 1.94;

}  // namespace explain
