// Where on the road a recording was driven, and what the road is like there.
#pragma once

#include "crg/surface.h"
#include "explain/signals.h"

namespace explain {

/// Fills the road under the car, its laps and rounds. Throws vehicle::Error naming the log when the
/// car stands, lies beside this road or drives against it.
void place_on_road(Signals& signals, const crg::Surface& surface);

}  // namespace explain
