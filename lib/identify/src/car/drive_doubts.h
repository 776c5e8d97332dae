// Whether the channels of a drive and the car of the vehicle file belong together.
#pragma once

#include <string>
#include <vector>

#include "identify/drive_windows.h"

namespace identify {

/// Why no number of these windows may be used; empty: nothing was found. `by_ax`: whether fits take
/// accelerations from ax_mps2.
std::vector<std::string> drive_doubts(const vehicle::Car<double>& car, const DriveWindows& drive,
                                      bool by_ax);

}  // namespace identify
