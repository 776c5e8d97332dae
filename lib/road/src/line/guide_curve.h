// The rows of a guide, before anything is measured.
#pragma once

#include "guide_rows.h"

namespace road {

inline constexpr double kUsualReach_m = 30.0;  ///< of a row to both sides; lengths of guides with a
                                               ///< smaller reach shrink with it

/// Where the rows stand, before anything is measured; their z is the guide's.
GuideRows empty_rows(const Guide& guide);

}  // namespace road
