// Heat capacities and conductances of brake discs from pressures, speeds and temperatures.
#pragma once

#include <array>

#include "identify/drive_fit.h"
#include "identify/drive_windows.h"

namespace identify {

struct DiscsFitOptions {
  std::array<double, 2> torque{1.0, 1.0};  ///< of each axle's brakes over the car's
  double torque_sd = 0.0;                  ///< share; heat is as wrong as it
};

/// The two nodes of laws/disc_heat.h, heated by pressure times the car's pad friction times speed,
/// run through the longest stretch of the recording and are held against the recorded
/// temperatures of the surfaces. Found of front and rear: disc_surface_capacity_jpk,
/// disc_core_capacity_jpk, disc_conductance_wpk, disc_area_m2 (as a measure of all cooling).
/// Nothing is thrown: what is missing is said in `unseen`.
DriveFit fit_discs(const vehicle::Car<double>& car, const Prior& prior,
                   const recording::Recording& recording, const DiscsFitOptions& options = {});

}  // namespace identify
