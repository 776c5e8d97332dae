// Friction of brake pads over pressure and disc temperature, from how a car slows down.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "identify/brakes_fit.h"
#include "vehicle/map.h"

namespace identify {

/// Friction at one place of the map.
struct PadCell {
  double pressure_pa = 0.0, surface_k = 0.0;
  double friction = 0.0, sd = 0.0, within = 0.0;  ///< half the 90 % interval
  double stated = 0.0;                            ///< the vehicle file's
  double seconds = 0.0;                           ///< near it, of all wheels
  std::string unseen;                             ///< why it is not observable; empty: it is
};

struct PadMapFit {
  std::vector<double> pressure_pa, surface_k;  ///< axes
  std::vector<PadCell> cells;                  ///< by pressure, then temperature; empty: none
  DriveFit fit;  ///< front_pads, rear_pads: of an axle over the mean of both, by its own area
};

struct PadMapOptions {
  double least_seconds = 1.0;  ///< of wheels near a place
  double most_share = 0.1;     ///< a place whose 90 % interval is wider either way is unseen
};

/// Force of the brakes as in fit_brakes = sum over the wheels of 2 * friction * pressure * area *
/// arm / radius. The friction is the vehicle file's (a map, or one number) and a smooth deviation
/// from it over pressure and temperature. Without pressures, temperatures or enough windows no
/// place is seen; `fit.remarks` say why.
PadMapFit fit_pad_map(const vehicle::Car<double>& car,
                      const std::array<double, vehicle::kParameterCount>& prior,
                      const DriveWindows& drive, const BrakesFitOptions& options = {},
                      const PadMapOptions& map_options = {});

/// The map for a car: places that were not seen as their neighbours and the stated shape say.
vehicle::Map2 pad_map_of(const PadMapFit& fit);

}  // namespace identify
