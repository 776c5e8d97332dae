// What a data sheet states of a car's performance, as the simulated car has it.
#pragma once

#include <string>

#include "vehicle/car.h"

namespace vehicle {

struct StraightRun {
  double to_100_kmh_s = 0.0;  ///< from the clutch to 100 km/h; 0: never reached
  double top_mps = 0.0;       ///< where the car gains less than 0.01 m/s2, at most after 240 s
  std::string problem;        ///< one sentence where the car could not be driven
};

/// From standstill straight on over a plane, with full throttle as far as the driven wheels slip no
/// more than they should, without fuel.
StraightRun run_straight(const Car<double>& car);

}  // namespace vehicle
