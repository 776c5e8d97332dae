// A road to compare cars on: every kind of turn, banks, a dip and a crest, no kerbs.
#pragma once

#include "crg/file.h"

namespace identify {

/// An open road of 2 km, 10 m wide, that does not cross itself: turns of 28 to 150 m radius both
/// ways, two of them banked by a tenth, a dip and a crest of 650 m radius, everything with smooth
/// transitions. The same bytes every time.
crg::Crg proving_road();

}  // namespace identify
