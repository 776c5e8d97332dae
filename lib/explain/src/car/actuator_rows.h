// What lies between a command and what was measured of it.
#pragma once

#include <vector>

#include "vehicle/parameters.h"

namespace explain {

/// Measured minus what the stated actuator makes of the command, at every Signals::kStep_s; NaN for
/// a second after a gap. `most`: what is reached at most; `amplitude`: of the actuator's term;
/// `dead_time`: the first of its four parameters.
void actuator_rows(std::vector<double>& out, const std::vector<double>& measured,
                   const std::vector<double>& command, double gain, double most, double amplitude,
                   const vehicle::Parameters<double>& p, vehicle::Parameter dead_time);

}  // namespace explain
