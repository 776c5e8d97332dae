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

/// With the wheelbase that steering, yaw rate and speed say in windows of less than 6 m/s2 to a
/// side: steering = wheelbase * yaw rate / speed + a share of the lateral acceleration + an offset
/// (T. D. Gillespie, Fundamentals of Vehicle Dynamics, 1992, 6). NaN stays where they tell nothing.
DriveWindows with_wheelbase(DriveWindows drive, const recording::Recording& recording);

/// By which share that is off the vehicle file's, where it is so clearly; else 0. A ratio of the
/// steering that is off looks the same.
double wheelbase_off(const vehicle::Car<double>& car, const DriveWindows& drive);

}  // namespace identify
