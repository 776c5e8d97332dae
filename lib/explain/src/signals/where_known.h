// Where a recording says enough for a relation: by the log alone, never by a setting.
#pragma once

#include <vector>

#include "explain/signals.h"

namespace explain {

/// Where it is known what drives: the throttle is logged, and the brakes are or cannot be on.
std::vector<bool> where_driven(const Signals& s);

/// Where a car led by what is logged drives and brakes as the recorded one did: both are logged, or
/// the speed hardly changes.
std::vector<bool> where_pushed_as_led(const Signals& s, const std::vector<bool>& driven);

/// Where the angle between the car and its path is logged, or matters little: it goes straight.
std::vector<bool> where_slip_known(const Signals& s);

/// Where a driven wheel slips so much that its speed says nothing about a force any more,
/// with the radius that most of the log has.
std::vector<bool> where_spinning(const Signals& s, double track_m);

}  // namespace explain
