// The file of a track.
#pragma once

#include "crg/file.h"

namespace road {

/// What crg::make_crg makes of both, with BORDER_MODE_U and BORDER_MODE_V 0,
/// because beside and beyond the grid is no road (the standard's default repeats the height of its
/// border).
crg::Crg track_crg(const crg::ReferenceLine& line, crg::Grid grid);

}  // namespace road
