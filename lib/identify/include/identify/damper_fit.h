// Dampers of a car from wheel loads and travels of a drive.
#pragma once

#include "identify/drive_fit.h"
#include "recording/recording.h"
#include "vehicle/car.h"

namespace identify {

/// Pieces of a twentieth of a second, of each wheel: load = spring * travel + bar * the other's
/// travel
/// + what side force, driving and braking press through the links + damper, in the shape that the
/// vehicle file gives it. Noise of the travels makes rates look larger than they are: its share is
/// found from the rows and taken out. Found of front and rear: bump_damping_nspm,
/// rebound_damping_nspm; with a damper map of the vehicle file bump_damper, rebound_damper as
/// factors on it. What is missing is said in `unseen`.
DriveFit fit_dampers(const vehicle::Car<double>& car, const recording::Recording& recording);

}  // namespace identify
