// Springs and anti-roll bars of a car from wheel loads and travels of a drive.
#pragma once

#include <string>

#include "identify/drive_fit.h"
#include "identify/drive_windows.h"

namespace identify {

/// Means over windows, of each axle: half the sum of the loads = spring rate * half the sum of the
/// travels + what braking, driving and cornering press through the links; half the difference =
/// (spring rate + 2 bar) * half the difference of the travels - what the links carry of the side
/// force, by the vehicle file. Found of front and rear: spring_npm, anti_roll_npm. `mass_kg` with
/// fuel. Dampers are not found: means over half a second do not show them. Throws base::Error
/// without loads or travels.
DriveFit fit_suspension(const vehicle::Car<double>& car, const Prior& prior,
                        const DriveWindows& drive, double mass_kg);

/// Lines of a setup sheet; remarks where something was not found.
std::string suspension_sheet(const DriveFit& fit);

}  // namespace identify
