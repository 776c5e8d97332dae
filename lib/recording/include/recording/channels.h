// What recordings of drives call their channels. Units and signs: docs/crgdrive.md.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace recording {

/// As channels, columns and keys are named after them.
inline constexpr std::array<const char*, 4> kWheelNames{"fl", "fr", "rl", "rr"};
inline constexpr std::array<const char*, 2> kAxleNames{"front", "rear"};

/// Names of the channels of a row of telemetry (vehicle/telemetry.h), units included, in order.
const std::vector<std::string>& telemetry_channels();

/// Every channel that a recording can have, with units: those of the telemetry, and wheel speeds in
/// m/s, one brake pressure for all wheels, the opponent's place.
const std::vector<std::string>& canonical_channels();

}  // namespace recording
