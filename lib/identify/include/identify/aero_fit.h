// Drag area of a car from how it slows down, or from how it pulls.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "identify/drive_fit.h"
#include "identify/drive_windows.h"

namespace identify {

struct AeroFitOptions : WeighedOptions {
  std::vector<std::pair<double, double>> engine_off_s;  ///< from, to: nothing drives or drags
};

/// By coast-downs (gear 0, or `engine_off_s`): inertia + rolling = - drag - rest. Without, at open
/// throttle: inertia + rolling = factor * engine map - drag. Found: drag_area_m2, and
/// rest_n: what slows the car at any speed beyond the vehicle file's rolling resistance, or an
/// offset of ax_mps2. Throws base::Error where accelerations are missing.
DriveFit fit_aero(const vehicle::Car<double>& car, const Prior& prior, const DriveWindows& drive,
                  const AeroFitOptions& options = {});

/// Line of a setup sheet; a remark where it was not found.
std::string aero_sheet(const DriveFit& fit);

}  // namespace identify
