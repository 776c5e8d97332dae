// What the road is where the car was, or will be, a little further along.
#pragma once

#include <cstddef>
#include <vector>

#include "explain/signals.h"

namespace explain {

/// Per step the place in the recording, in steps and parts of them, at which the car is `shift_m`
/// further along its way; before its begin and behind its end these.
std::vector<double> further_along(const Signals& signals, double shift_m);

/// A series between its steps, straight; NaN beside a gap.
double at_step(const std::vector<double>& x, double place);

}  // namespace explain
