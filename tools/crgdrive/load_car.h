// The car that the command line asks for.
#pragma once

#include "commands.h"
#include "vehicle/step.h"
#include "vehicle/vehicle_file.h"

namespace crgdrive {

/// The vehicle with its setup and settings; throws vehicle::Error.
vehicle::Vehicle load_vehicle(const CarOptions& options);

vehicle::StepOptions step_options(const CarOptions& options);

}  // namespace crgdrive
