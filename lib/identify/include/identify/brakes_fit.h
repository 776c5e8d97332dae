// Torque of the brakes from how a car slows down under known pressures.
#pragma once

#include <string>

#include "identify/drive_fit.h"
#include "identify/drive_windows.h"

namespace identify {

/// Force of the brakes = engine's drag - inertia - rolling - drag = factor of the front * its
/// torque by the vehicle file + factor of the rear * its torque. Found: front_torque, rear_torque
/// (factors on the vehicle file's), torque (one factor for both), and factors of both at the
/// pressures and disc temperatures that were visited, torque_20_40_bar or
/// torque_20_40_bar_500_700_k. Throws base::Error without pressures.
DriveFit fit_brakes(const vehicle::Car<double>& car, const Prior& prior, const DriveWindows& drive,
                    const WeighedOptions& options = {});

/// Lines of a setup sheet; a remark where nothing was found.
std::string brakes_sheet(const vehicle::Car<double>& car, const DriveFit& fit);

}  // namespace identify
