#pragma once

#include <optional>
#include <string>
#include <vector>

#include "explain/signals.h"

namespace explain {

/// Columns of one device whose clock is behind that of the others by so much in a recording:
/// positions, or gyro and accelerometer, or what comes over the car's bus. By the shift at which
/// rates of heading, speed and acceleration follow the path best; a single column is left to the
/// analysis, which knows filters as well. None below 0.06 s, or where the devices do not agree
/// among themselves within 0.03 s.
std::optional<LateColumns> late_together(const Signals& signals);

}  // namespace explain
