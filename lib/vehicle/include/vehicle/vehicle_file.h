// A vehicle folder: vehicle.yaml and the files it points to.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "vehicle/car.h"

namespace vehicle {

/// A car as its files describe it. Not movable once a Car refers to `files`.
struct Vehicle {
  std::string name;
  CarFiles files;
  Parameters<double> parameters = default_parameters();
  std::array<double, kParameterCount> prior;    ///< as in ParameterInfo
  std::array<bool, kParameterCount> stated{};   ///< in the file, not the default
  std::array<bool, kParameterCount> assumed{};  ///< marked in the file as not known
  Amplitudes<double> terms = default_amplitudes();
  Contact contact = Contact::kSinglePoint;
  std::vector<std::string> read_files;  ///< every file that was read, vehicle.yaml first
};

/// Reads vehicle.yaml (docs/vehicle_files.md) and everything it names; paths are relative to it.
/// Throws Error with file:line on unknown or repeated keys, values out of bounds, missing files,
/// and what make_car would refuse.
Vehicle read_vehicle(const std::string& path);

/// Sets "group.key=value" (a parameter), with "prior 0.01" behind the value where its prior is
/// another than the vehicle file's, or "term=amplitude", as --set on the command line does.
/// Throws Error naming `where`.
void apply_setting(Vehicle& vehicle, std::string_view setting, const std::string& where);

/// Reads lines "group.key = value", or "group.key = value prior 0.01" (# begins a remark), into the
/// vehicle: a setup sheet. Throws Error with file:line.
void read_setup(Vehicle& vehicle, const std::string& path);

/// The three together, as the command line has them: the file, the setup sheet where `setup_path`
/// names one, then each "name=value" of --set. Throws Error as they do.
Vehicle read_vehicle(const std::string& path, const std::string& setup_path,
                     const std::vector<std::string>& settings);

}  // namespace vehicle
