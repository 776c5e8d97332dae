// Torque map of an engine from how a car speeds up and slows down.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "identify/drive_fit.h"
#include "identify/drive_windows.h"
#include "vehicle/map.h"

namespace identify {

struct EngineFitOptions {
  double mass_kg = 0.0;     ///< with fuel; 0: the vehicle file's and fuel_kg
  double mass_sd_kg = 0.0;  ///< of it; with mass_kg 0 that of the vehicle file's prior
  double fuel_kg = 30.0;
  bool body_axes = true;              ///< as the windows'
  double most_left_mps2 = 8.0;        ///< windows that turn more do not count
  double most_left_blind_mps2 = 2.0;  ///< the same where the steering was not recorded
  double most_brake_pa = 5e4;
  double least_seconds = 1.0;  ///< at a place of the map, counted by how near
  double most_share = 0.1;     ///< a place whose 90 % interval is wider, as a share of its torque
                               ///< or of a quarter of the largest, is unseen
};

/// Torque at one place of the map: what the crankshaft gives with full boost, factors included.
struct EngineCell {
  double engine_radps = 0.0, throttle = 0.0;
  double torque_nm = 0.0, sd_nm = 0.0, within_nm = 0.0;  ///< half the 90 % interval
  double stated_nm = 0.0;                                ///< the vehicle file's
  std::vector<double> gear_s;                            ///< seconds near it in each gear
  std::string unseen;                                    ///< why it is not observable; empty: it is
};

struct EngineFit {
  DriveFit fit;  ///< torque: the found over the stated map, mean of the places seen; torque_gear_3:
                 ///< of that gear over the map of all
  std::vector<double> engine_radps, throttle;  ///< axes
  std::vector<EngineCell> cells;               ///< by engine speed, then throttle
};

/// Mass * acceleration + what turns + rolling + drag + front side force over the steering =
/// (torque - engine inertia * its acceleration) * ratio / radius, window by window, of straight and
/// turning, unbraked windows in one gear. The torque is the vehicle file's map and a smooth
/// deviation from it, found at all its places at once. Throws base::Error without throttle, and
/// for a car with the full turbocharged engine, which has no map.
EngineFit fit_engine(const vehicle::Car<double>& car,
                     const std::array<double, vehicle::kParameterCount>& prior,
                     const DriveWindows& drive, const recording::Recording& recording,
                     const EngineFitOptions& options = {});

/// The map for a car: places that were not seen as their neighbours and the stated shape say.
vehicle::Map2 engine_map_of(const EngineFit& fit);

}  // namespace identify
