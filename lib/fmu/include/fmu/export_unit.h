// A car, a road and the shared object that drives them, as the bytes of one .fmu.
#pragma once

#include <string>
#include <vector>

#include "fmu/model_description.h"

namespace fmu {

struct ExportOptions {
  std::string vehicle_path;
  std::string setup_path;             ///< after the vehicle's own; empty: none
  std::vector<std::string> settings;  ///< name=value, after the setup
  std::string road_path;              ///< empty: a level plane
  std::string friction_path;          ///< empty: none
  std::string contact;                ///< single-point ...; empty: as the vehicle file says
  std::string integrator = "semi-implicit";
  double step_s = 0.001;
  std::string binary_path;      ///< kerbstone_car.so
  std::string generation_tool;  ///< name and version
  Version version = Version::kFmi2;
};

struct Exported {
  std::string bytes;  ///< of the .fmu
  std::string model_name, token;
  std::size_t variables = 0;        ///< in the model description
  std::vector<std::string> files;   ///< within the unit
  std::vector<std::string> inputs;  ///< files that were read
};

/// Packs everything that the unit needs, so that it needs no other file. The car begins on the
/// middle of the road: where a closed one begins, on an open one with its wheels on it. The same
/// inputs give the same bytes. Throws base::Error, also where the vehicle file names files by
/// absolute paths, which another machine has not.
Exported export_unit(const ExportOptions& options);

/// The same unit for this machine alone: its files stay where they lie.
struct UnitInPlace {
  std::string description;  ///< modelDescription.xml
  std::string unit_file;    ///< resources/unit.txt
};

/// Of the options it takes the vehicle, road, friction, contact, integrator, step and version.
UnitInPlace unit_in_place(const ExportOptions& options);

}  // namespace fmu
