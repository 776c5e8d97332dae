// What `crgidentify engine` tells: text, JSON, files for a car, a page.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "identify/engine_fit.h"

namespace crgidentify {

/// The map as a table: torque and half its 90 % interval, empty where it is not observable.
std::string engine_table(const identify::EngineFit& fit);
nlohmann::ordered_json engine_json(const identify::EngineFit& fit);

/// The map as a vehicle file reads it; every place has a number.
std::string engine_map_csv(const identify::EngineFit& fit);
/// Every place with its interval and the seconds in each gear; torques empty where unseen.
std::string engine_cells_csv(const identify::EngineFit& fit);
bool is_any_seen(const identify::EngineFit& fit);
/// Lines for a vehicle file, none where no place of the map was seen; `map_name` is the map's file
/// beside it.
std::string engine_yaml(const identify::EngineFit& fit, const std::string& map_name);

std::string engine_page(const identify::EngineFit& fit, const std::string& title);

}  // namespace crgidentify
