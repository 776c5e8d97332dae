// The steps of `crgexplain run`, in their order.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "commands.h"
#include "crg/surface.h"
#include "explain/mapping.h"
#include "explain/signals.h"
#include "explain/write_back.h"
#include "stages.h"
#include "vehicle/vehicle_file.h"

namespace crgexplain {

/// Throws vehicle::Error for a car that crgexplain cannot reckon with, and for fuel that is no
/// number.
vehicle::Vehicle read_car(const RunCommand& command);

struct Road {
  std::optional<crg::Crg> friction;
  crg::Surface surface;  ///< with that friction
};

/// `friction_path` may be empty.
Road read_road(const std::string& track_path, const std::string& friction_path);

struct Recordings {
  std::vector<vehicle::Table> tables;
  std::vector<explain::Signals> logs;  ///< of the same tables
  explain::Mapping given;     ///< as it names the columns of the log: latitudes not yet on a plane
  explain::Mapping recorded;  ///< of the columns that were recorded
  explain::Mapping read;      ///< the same with the column of the fuel that was given, if any was
  std::vector<std::string> notes;

  std::vector<explain::RecordedLog> all() const;
};

/// With `--fuel-kg` every table gets a column of fuel that burns as vehicle.yaml says.
Recordings read_recordings(const RunCommand& command, const crg::Surface& surface,
                           const vehicle::Vehicle& car);

/// What a simulation is to take from now on: corrected where something was found, as given
/// elsewhere.
struct Corrected {
  std::string track_path, friction_path, vehicle_path, mapping_path;
  std::optional<explain::Mapping> mapping;  ///< of the recorded columns, if it was corrected
  double fuel_kg = 0.0;                     ///< at the begin of the logs, given or found
};

/// Nothing that is read may lie where a corrected input will be written. Throws vehicle::Error.
void refuse_to_overwrite(const std::vector<std::string>& inputs, const std::string& folder);

/// Writes the corrected inputs into a folder; none is left over there from an earlier run.
Corrected write_corrected(const RunCommand& command, const std::string& folder, const Road& road,
                          const vehicle::Vehicle& car, const Recordings& recordings,
                          const explain::Findings& findings);

/// vehicle.yaml comes last: whoever finds it finds what it names.
void write_car(const explain::CorrectedCar& car, const std::string& folder);

/// Drives the whole simulated car with the stated and with the corrected inputs, writes those with
/// which it is better on laps left out, says of every other finding why it is not used, and adds
/// what came out of driving. The refitted car replaces the corrected one: what was driven is what
/// is handed out.
Corrected use_what_helps(const RunCommand& command, const Road& road, const vehicle::Vehicle& car,
                         const Recordings& recordings, const Stages& stages,
                         const base::Progress& progress, explain::Findings& findings);

/// Verdict, findings and the commands that go on from here.
void print_result(const RunCommand& command, const Recordings& recordings,
                  const explain::Findings& findings, const Corrected& corrected,
                  Terminal& terminal);

}  // namespace crgexplain
