// As channels, columns and keys are named after them.
#pragma once

#include <array>

#include "vehicle/car.h"

namespace identify {

inline constexpr std::array<const char*, vehicle::kWheels> kWheelNames{"fl", "fr", "rl", "rr"};
inline constexpr std::array<const char*, 2> kAxleNames{"front", "rear"};

}  // namespace identify
