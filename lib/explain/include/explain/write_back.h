// The corrected inputs: what a finding changes in road, car and mapping.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "crg/file.h"
#include "explain/findings.h"
#include "explain/mapping.h"
#include "explain/simulate.h"
#include "vehicle/vehicle_file.h"

namespace explain {

/// The road with the profiles of the findings of kind road that are heights (banking, grade,
/// vertical curvature) added to its grid, and its heights moved along u where they are misplaced;
/// nothing when there are none. Throws crg's or vehicle's error when the file's modifiers cannot be
/// worked in.
std::optional<crg::Crg> corrected_road(const crg::Crg& road, const Findings& findings);

/// A friction map (docs/crgdrive.md) of the road's shape with the findings about its grip, times
/// the map that was known, if one was; nothing when there are none. What a finding says about cells
/// of 10 m is steadied: by its intervals, a tenth for what stated tyre curves get wrong, and steps
/// of 0.05.
std::optional<crg::Crg> friction_map(const crg::Crg& road, const crg::Crg* known,
                                     const Findings& findings);

/// A corrected car: vehicle.yaml and what stands beside it.
struct CorrectedCar {
  std::string vehicle_yaml;
  std::vector<std::pair<std::string, std::string>>
      files;             ///< name and text of every file that it names anew
  double fuel_kg = 0.0;  ///< with which it drives a log from its begin, if that was found
};

/// Every file that a corrected car may bring beside vehicle.yaml.
inline constexpr std::array<const char*, 6> kCarFiles{
    "engine.csv", "front.tir", "rear.tir", "drag.csv", "front_lift.csv", "rear_lift.csv"};

/// The vehicle file with terms, parameters, tyres and maps as found: amounts are added to the
/// stated ones; what no term, parameter, tyre or map can hold stands as a remark at its head. Paths
/// of files that stay are made absolute. Nothing when nothing about the car was found, or when it
/// is doubtful whether it is this car's file. `logs` say at which speeds and on which channels it
/// was found. With `refit`, the parameters that it changed as well, and `engine.csv` as engine map.
std::optional<CorrectedCar> corrected_vehicle(const std::string& vehicle_path,
                                              const vehicle::Vehicle& car, const Findings& findings,
                                              const std::vector<Signals>& logs,
                                              const RefittedCar* refit = nullptr);

/// A map over two axes as vehicle files have it (docs/vehicle_files.md); `axes`: names of both,
/// "x:y".
std::string map_csv(const vehicle::Map2& map, const std::string& axes);

/// The mapping with sensor findings taken out; a wheel radius that is off in logs of wheel speeds
/// in m/s is the logger's. Where steering, throttle or brakes act late on a measured position or
/// pressure and the stated car has no actuator there, the column becomes the command of the one
/// that corrected_vehicle() adds. Nothing when nothing changes.
std::optional<Mapping> corrected_mapping(const Mapping& mapping, const vehicle::Vehicle& car,
                                         const Findings& findings,
                                         const std::vector<Signals>& logs);

/// What a simulation is made from, as stated.
struct StatedInputs {
  const crg::Crg& road;
  const crg::Crg* friction = nullptr;  ///< if a map is known
  std::string vehicle_path;
  const vehicle::Vehicle& car;
  const Mapping& mapping;  ///< of the recorded columns
};

/// Each is nothing where no finding changes it.
struct CorrectedInputs {
  std::optional<crg::Crg> road, friction;
  std::optional<CorrectedCar> car;
  std::optional<Mapping> mapping;
};

/// All inputs with everything that was found, as each mechanism writes it.
CorrectedInputs correct(const StatedInputs& stated, const Findings& findings,
                        const std::vector<Signals>& logs);

}  // namespace explain
