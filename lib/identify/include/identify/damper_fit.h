// Dampers of a car from wheel loads and travels of a drive.
#pragma once

#include "identify/drive_fit.h"
#include "recording/recording.h"
#include "vehicle/car.h"

namespace identify {

struct DamperFitOptions {
  double seconds = 0.05;   ///< rates are slopes over so long: shorter is noise, longer is no rate
  double least_mps = 5.0;  ///< slower rows are left out
  double model_share = 0.05;  ///< standard deviation of what straight pieces and links leave out:
                              ///< measured on the simulated car
  double most_share = 0.25;   ///< a number whose 90 % interval is wider either way is unseen
};

/// Pieces of a twentieth of a second, of each wheel: load = spring * travel + bar * the other's
/// travel
/// + what side force, driving and braking press through the links + damper, in the shape that the
/// vehicle file gives it. Noise of the travels makes rates look larger than they are: its share is
/// found from the rows and taken out. Found of front and rear: bump_damping_nspm,
/// rebound_damping_nspm; with a damper map of the vehicle file bump_damper, rebound_damper as
/// factors on it. What is missing is said in `unseen`.
DriveFit fit_dampers(const vehicle::Car<double>& car, const recording::Recording& recording,
                     const DamperFitOptions& options = {});

}  // namespace identify
