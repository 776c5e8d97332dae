// The gear that a recording was driven in.
#pragma once

#include <vector>

#include "explain/signals.h"
#include "vehicle/vehicle_file.h"

namespace explain {

/// The gear at every step, and where it is none or changes: the log's, the one whose ratio joins
/// engine and wheels, or the one that the car's driver would choose.
struct Gears {
  std::vector<int> gear;
  std::vector<bool> shifting;
};

/// `radius_m`: in which the rear wheels roll.
Gears gears_of(const Signals& s, const vehicle::Vehicle& car, double radius_m);

}  // namespace explain
