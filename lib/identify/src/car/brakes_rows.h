// The windows of a drive in which brakes show their torque, and what they say of it.
#pragma once

#include <cstddef>
#include <vector>

#include "identify/brakes_fit.h"
#include "longitudinal.h"

namespace identify {

/// Whether a window shows the brakes alone: BrakesFitOptions.
bool brakes_count(const vehicle::Car<double>& car, const DriveWindow& w,
                  const BrakesFitOptions& options);

/// Force on the road of an axle's brakes by the vehicle file, N, positive.
double stated_force(const vehicle::Car<double>& car, const DriveWindow& w, std::size_t axle,
                    double mass_kg);

/// What the fits take for granted, moved by one standard deviation each.
std::vector<Granted> brakes_moved(const Along& along);

/// What slows the car beyond drag, rolling resistance and the engine's drag, N, positive.
double braking_force(const vehicle::Car<double>& car, const DriveWindow& w, bool by_speed,
                     const Granted& g);

}  // namespace identify
