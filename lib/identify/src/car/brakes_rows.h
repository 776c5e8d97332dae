// The windows of a drive in which brakes show their torque, and what they say of it.
#pragma once

#include <cstddef>
#include <vector>

#include "identify/drive_fits.h"
#include "longitudinal.h"

namespace identify {

/// Less is no braking.
inline constexpr double kBraking_pa = 5e5;

/// Whether a window shows the brakes alone: pressed, hardly turning (tyres drag there), no wheel
/// slower than 85 % of the car.
bool brakes_count(const vehicle::Car<double>& car, const DriveWindow& w);

/// Force on the road of an axle's brakes by the vehicle file, N, positive.
double stated_force(const vehicle::Car<double>& car, const DriveWindow& w, std::size_t axle,
                    double mass_kg);

/// What the fits take for granted, moved by one standard deviation each.
std::vector<Granted> brakes_moved(const Along& along);

/// What slows the car beyond drag, rolling resistance and the engine's drag, N, positive.
double braking_force(const vehicle::Car<double>& car, const DriveWindow& w, bool by_speed,
                     const Granted& g);

}  // namespace identify
