// A gyro that shows too little, or a road that leans?
#pragma once

#include "explain/findings.h"
#include "explain/signals.h"

namespace explain {

/// A gyro on a road that leans by an angle shows the yaw rate times its cosine: as one whose gain
/// is too low, wherever the road turns. Where lateral acceleration and lateral speed are not both
/// logged, nothing else tells the two apart: a gain below 1 then has banking as its equal, and is
/// not written back.
void tie_gain_with_banking(const Signals& log, Findings& findings);

}  // namespace explain
