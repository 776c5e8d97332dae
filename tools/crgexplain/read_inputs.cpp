#include "crg/file.h"
#include "explain/fuel.h"
#include "run_steps.h"

namespace crgexplain {

Road read_road(const std::string& track_path, const std::string& friction_path) {
  crg::SurfaceOptions options;
  if (!friction_path.empty()) options.friction_map = crg::read(friction_path);
  return {options.friction_map, crg::Surface(crg::read(track_path), options)};
}

std::vector<explain::RecordedLog> Recordings::all() const {
  std::vector<explain::RecordedLog> out;
  for (std::size_t k = 0; k < logs.size(); ++k) out.push_back({&tables[k], &logs[k]});
  return out;
}

Recordings read_recordings(const RunCommand& command, const crg::Surface& surface, const vehicle::Vehicle& car) {
  Recordings out;
  explain::Mapping given;
  if (!command.mapping_path.empty()) given = {vehicle::read_mapping(command.mapping_path), {}};
  for (const std::string& path : command.recording_paths) {
    vehicle::Table& table = out.tables.emplace_back(vehicle::read_table(path));
    out.recorded = command.mapping_path.empty() ? explain::identity_mapping(table) : given;
    for (const std::string& note : out.recorded.notes) out.notes.push_back(path + ": " + note);
    explain::Signals& log = out.logs.emplace_back(explain::make_signals(table, out.recorded, surface, path));
    out.read = out.recorded;
    if (command.fuel_kg > 0) {
      explain::add_fuel(table, out.read, log, car, command.fuel_kg);
      log = explain::make_signals(table, out.read, surface, path);
    }
  }
  return out;
}

}  // namespace crgexplain
