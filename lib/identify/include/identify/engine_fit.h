// Torque map of an engine from how a car speeds up and slows down.
#pragma once

#include "identify/drive_fit.h"
#include "identify/drive_windows.h"

namespace identify {

struct EngineFitOptions : WeighedOptions {
  double most_left_mps2 = 8.0;        ///< windows that turn more do not count
  double most_left_blind_mps2 = 2.0;  ///< the same where the steering was not recorded
  double most_brake_pa = 5e4;
  double least_seconds = 1.0;  ///< at a place of the map, counted by how near
  double most_share = 0.1;     ///< a place whose 90 % interval is wider, as a share of its torque
                               ///< or of a quarter of the largest, is unseen
};

/// Torque, N m, over engine speed, rad/s, and throttle: what the crankshaft gives with full boost,
/// factors included. Of its `fit` torque is the found over the stated map, mean of the places seen;
/// torque_gear_3 that of this gear over the map of all.
using EngineFit = FoundMap;

/// Mass * acceleration + what turns + rolling + drag + front side force over the steering =
/// (torque - engine inertia * its acceleration) * ratio / radius, window by window, of straight and
/// turning, unbraked windows in one gear. The torque is the vehicle file's map and a smooth
/// deviation from it, found at all its places at once. Throws base::Error without throttle, and
/// for a car with the full turbocharged engine, which has no map.
EngineFit fit_engine(const vehicle::Car<double>& car, const Prior& prior, const DriveWindows& drive,
                     const recording::Recording& recording, const EngineFitOptions& options = {});

}  // namespace identify
