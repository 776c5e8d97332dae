// A gyro that shows too little, or a road that leans?
#pragma once

#include <string>

#include "explain/findings.h"
#include "explain/signals.h"

namespace explain {

/// Mechanism, kind and words of a banking that turning alone tells.
void call_banking(Finding& finding);
/// Such a banking has a gain of the yaw rate as its equal, and is not written back.
void add_gain_as_equal(Finding& finding, const std::string& column, double gain, double cv_gain);

/// A gyro on a road that leans by an angle shows the yaw rate times its cosine: as one whose gain
/// is too low, wherever the road turns. Where lateral acceleration and lateral speed are not both
/// logged, nothing else tells the two apart: a finding of a gain below 1 becomes one of banking,
/// with the gain as its equal.
void tie_gain_with_banking(const Signals& log, Findings& findings);

}  // namespace explain
