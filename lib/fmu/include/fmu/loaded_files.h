// What the texts of a unit name, read.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "fmu/variables.h"
#include "vehicle/road.h"
#include "vehicle/step.h"
#include "vehicle/vehicle_file.h"

namespace fmu {

using Texts = std::array<std::string, kTextCount>;

/// Never changed after loading; cars and roads refer to it.
struct LoadedFiles {
  Texts texts;
  vehicle::Vehicle vehicle;  ///< with the setup and the contact of the texts
  std::optional<crg::Surface> surface;
  vehicle::Road road;  ///< on the surface, or the level plane
  vehicle::Integrator integrator = vehicle::Integrator::kSemiImplicit;
};

/// Paths that do not begin with / lie in the folder that the texts name, else in `resources`.
/// Throws base::Error for files that are missing or wrong, and words that are none.
std::shared_ptr<const LoadedFiles> load_files(const Texts& texts, const std::string& resources);

}  // namespace fmu
