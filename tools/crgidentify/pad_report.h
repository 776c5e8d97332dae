// What `crgidentify brakes` tells of the pads' friction: text, JSON, a map for a car, a page.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "identify/pad_map_fit.h"

namespace crgidentify {

/// Friction and half its 90 % interval over pressure and temperature, empty where unseen.
std::string pad_table(const identify::PadMapFit& fit);
nlohmann::ordered_json pad_json(const identify::PadMapFit& fit);
/// The map as a vehicle file reads it; every place has a number.
std::string pad_map_csv(const identify::PadMapFit& fit);
std::string pad_page(const identify::PadMapFit& fit, const identify::DriveFit& brakes,
                     const std::string& title);

}  // namespace crgidentify
