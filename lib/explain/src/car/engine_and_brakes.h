// What the relations and the refit of the whole car change alike in engine and brakes.
#pragma once

#include <array>
#include <vector>

#include "vehicle/vehicle_file.h"

namespace explain {

/// The engine map times one plus a shape over throttle and speed: what no stated map has right. The
/// same four shapes as in the relations.
vehicle::Map2 shaped_engine_map(const vehicle::Map2& stated, const std::array<double, 4>& shape,
                                double limit_radps);

/// What makes the brakes stronger on measured pressures: friction of the pads, or the pistons' area
/// where a map gives the friction.
std::vector<vehicle::Parameter> brake_strength(const vehicle::Vehicle& car);

}  // namespace explain
