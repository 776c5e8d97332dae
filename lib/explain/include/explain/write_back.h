// The corrected inputs: what a finding changes in road, car and mapping.
#pragma once

#include <optional>
#include <string>

#include "crg/file.h"
#include "explain/findings.h"
#include "explain/mapping.h"
#include "explain/simulate.h"
#include "vehicle/vehicle_file.h"

namespace explain {

/// The road with the profiles of the findings of kind road that are heights (banking, grade,
/// vertical curvature) added to its grid; nothing when there are none. Throws crg's or vehicle's
/// error when the file's modifiers cannot be worked in.
std::optional<crg::Crg> corrected_road(const crg::Crg& road, const Findings& findings);

/// A friction map (docs/crgdrive.md) of the road's shape with the findings about its grip, times the
/// map that was known, if one was; nothing when there are none.
std::optional<crg::Crg> friction_map(const crg::Crg& road, const crg::Crg* known, const Findings& findings);

/// The vehicle file's text with terms and parameters as found: paths as in the original, made
/// absolute. Empty when nothing about the car was found. With `refit`, the parameters that it changed
/// as well, and `engine.csv` beside the file as engine map: engine_map_csv() writes it.
std::string corrected_vehicle(const std::string& vehicle_path, const vehicle::Vehicle& car, const Findings& findings, const RefittedCar* refit = nullptr);

/// A map of engine torque as vehicle files have it (docs/vehicle_files.md).
std::string engine_map_csv(const vehicle::Map2& map);

/// The mapping with sensor findings taken out; nothing when there are none.
std::optional<Mapping> corrected_mapping(const Mapping& mapping, const Findings& findings);

}  // namespace explain
