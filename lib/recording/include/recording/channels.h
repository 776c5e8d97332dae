// What recordings of drives call their channels. Units and signs: docs/crgdrive.md.
#pragma once

#include <string>
#include <vector>

namespace recording {

/// Names of the channels of a row of telemetry (vehicle/telemetry.h), units included, in order.
const std::vector<std::string>& telemetry_channels();

/// Every channel that a recording can have, with units: those of the telemetry, and wheel speeds in
/// m/s, one brake pressure for all wheels, the opponent's place.
const std::vector<std::string>& canonical_channels();

}  // namespace recording
