// Torque map of an engine from how a car speeds up and slows down.
#pragma once

#include "identify/drive_fit.h"
#include "identify/drive_windows.h"

namespace identify {

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
                     const recording::Recording& recording, const WeighedOptions& options = {});

}  // namespace identify
