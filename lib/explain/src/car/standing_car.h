// What follows from how the stated car stands, without fuel.
#pragma once

#include "vehicle/vehicle_file.h"

namespace explain {

/// On one wheel of an axle, N.
double standing_load_n(const vehicle::Vehicle& car, std::size_t axle);

/// In which an axle's tyres then roll, m.
double standing_radius_m(const vehicle::Vehicle& car, std::size_t axle);

}  // namespace explain
