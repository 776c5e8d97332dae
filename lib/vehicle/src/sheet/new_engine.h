// Engine and gears of a new car.
#pragma once

#include <string>

#include "basis.h"

namespace vehicle {

void add_engine(const Basis& b);
void add_gears(const Basis& b);

/// The engine's map: at full throttle the sheet's torque; closed, friction that grows with speed;
/// between them the shape of the map of vehicles/open_wheel.
std::string engine_map_text(const DataSheet& sheet);

}  // namespace vehicle
