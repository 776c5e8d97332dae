// Is the vehicle file that of the car in the recordings?
#pragma once

#include "explain/findings.h"

namespace explain {

/// Whether findings of this kind rest on the vehicle file.
bool is_of_the_car(const std::string& kind);

/// Two or more parameters beyond their priors and more than 30 % off, or three and more than 20 %,
/// of two kinds or more: a remark, verdict `unknown`, and corrected_vehicle() gives nothing.
void doubt_the_car(Findings& findings);

}  // namespace explain
