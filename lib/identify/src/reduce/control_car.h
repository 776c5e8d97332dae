// The reduced car as C text, read as C++: the same lines that control_header() writes.
#pragma once

#include <cmath>

namespace identify::control {

#include "control_car.inc"
#include "control_double_track.inc"
#include "control_single_track.inc"

}  // namespace identify::control
