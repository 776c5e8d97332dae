// What a comparison of recordings with a simulation reads.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "crg/surface.h"
#include "explain/explain_files.h"
#include "explain/mapping.h"
#include "explain/signals.h"
#include "explain/simulate.h"
#include "vehicle/vehicle_file.h"

namespace explain {

/// Throws vehicle::Error for a car that this library cannot reckon with, and for fuel that is no
/// number.
vehicle::Vehicle read_car(const ExplainRequest& request);

struct StatedRoad {
  std::optional<crg::Crg> friction;
  crg::Surface surface;  ///< with that friction
};

/// `friction_path` may be empty.
StatedRoad read_road(const std::string& track_path, const std::string& friction_path);

struct Recordings {
  std::vector<recording::Table> tables;
  std::vector<Signals> logs;  ///< of the same tables
  Mapping given;              ///< as it names the columns of the log: latitudes not yet on a plane
  Mapping recorded;           ///< of the columns that were recorded
  Mapping read;               ///< the same with the column of the fuel that was given, if any was
  std::vector<std::string> notes;

  std::vector<RecordedLog> all() const;
};

/// With `--fuel-kg` every table gets a column of fuel that burns as vehicle.yaml says.
Recordings read_recordings(const ExplainRequest& request, const crg::Surface& surface,
                           const vehicle::Vehicle& car);

}  // namespace explain
