// How late a sensor may tell what it saw.
#pragma once

namespace vehicle {

inline constexpr double kLongestDelay_s = 10.0;

}  // namespace vehicle
