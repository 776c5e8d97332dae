// What messages call the wheels.
#pragma once

#include <array>
#include <string_view>

#include "vehicle/state.h"

namespace vehicle {

inline constexpr std::array<std::string_view, kWheels> kWheelNames{"front left", "front right",
                                                                   "rear left", "rear right"};

}  // namespace vehicle
