// The windows of a drive in which brakes show their torque, and what they say of it.
#pragma once

#include <cstddef>
#include <vector>

#include "identify/brakes_fit.h"
#include "identify/drive_windows.h"

namespace identify {

/// Whether a window shows the brakes alone: BrakesFitOptions.
bool brakes_count(const vehicle::Car<double>& car, const DriveWindow& w,
                  const BrakesFitOptions& options);

/// Force on the road of an axle's brakes by the vehicle file, N, positive.
double stated_force(const vehicle::Car<double>& car, const DriveWindow& w, std::size_t axle,
                    double mass_kg);

/// What the fit takes for granted, moved to see what it does.
struct BrakesGranted {
  double mass_kg = 0.0, rolling = 1.0, engine = 1.0, drag = 1.0, offset_mps2 = 0.0;
};

/// Each of these moved by one standard deviation.
std::vector<BrakesGranted> brakes_granted(double mass_kg, double mass_sd_kg, double drag_sd_share);

/// What slows the car beyond drag, rolling resistance and the engine's drag, N, positive.
double braking_force(const vehicle::Car<double>& car, const DriveWindow& w, bool by_speed,
                     const BrakesGranted& g);

}  // namespace identify
