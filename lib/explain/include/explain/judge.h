#pragma once

#include "explain/findings.h"

namespace explain {

/// The verdict, from everything that was found and left over. Where several things stand, the
/// strongest claim that holds for the whole: explained only if nothing significant is left.
Verdict judge(const Findings& findings);

}  // namespace explain
