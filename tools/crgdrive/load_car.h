// The car that the command line asks for.
#pragma once

#include "commands.h"
#include "crg/surface.h"
#include "recording/table.h"
#include "vehicle/step.h"
#include "vehicle/vehicle_file.h"

namespace crgdrive {

/// The vehicle with its setup and settings; throws vehicle::Error.
vehicle::Vehicle load_vehicle(const CarOptions& options);

/// The road with its friction map (empty path: none). Throws vehicle::Error where the map has a
/// value that no grip factor has; remarks how much of the road it leaves without one.
crg::Surface read_road(const std::string& track_path, const std::string& friction_path,
                       Terminal& terminal);

vehicle::StepOptions step_options(const CarOptions& options);

/// Whole steps between two rows of telemetry, nearest to the rate; remarks the rate that comes out
/// where it is another one. Throws vehicle::Error when rows are wanted faster than steps.
std::size_t steps_per_row(double rate_hz, double step_s, Terminal& terminal);

/// Throws vehicle::Error when most places (columns x_m, y_m of a recording) lie beside the road: it
/// is another one, or its frame is.
void require_on_road(const crg::Surface& road, const std::string& road_path,
                     const recording::Table& table, const std::string& table_path);

/// What made a run, as remarks before its table: the files with their SHA-256 (those of the car and
/// `more`), settings, terms.
std::string provenance(const std::string& run, const vehicle::Vehicle& car,
                       const CarOptions& options, const std::vector<std::string>& more);

}  // namespace crgdrive
