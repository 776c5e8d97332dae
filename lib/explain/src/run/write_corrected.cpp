#include <fmt/format.h>

#include <filesystem>

#include "base/output_set.h"
#include "base/write_file.h"
#include "crg/file.h"
#include "run_steps.h"
#include "vehicle/error.h"

namespace explain {
namespace {

/// The corrected inputs, as they are called in the folder of the result.
std::vector<std::string> corrected_names() {
  std::vector<std::string> out{"track.crg", "friction.crg", "vehicle.yaml", "mapping.yaml"};
  out.insert(out.end(), kCarFiles.begin(), kCarFiles.end());
  return out;
}

/// With the columns of the log: it has latitudes, no "east of origin".
Mapping as_given(Mapping mapping, const Mapping& given) {
  if (!mapping.has_origin) return mapping;
  for (ColumnMapping& m : mapping.columns)
    for (const ColumnMapping& g : given.columns) {
      const bool east = m.column.starts_with("east of origin") && g.channel == "latitude_rad";
      const bool north = m.column.starts_with("north of origin") && g.channel == "longitude_rad";
      if (east || north)
        m = {g.column, g.channel, g.scale, g.offset, m.delay_s, m.low_pass_s, m.held};
    }
  return mapping;
}

}  // namespace

void refuse_to_overwrite(const std::vector<std::string>& inputs, const std::string& folder) {
  for (const std::string& input : inputs)
    for (const std::string& name : corrected_names()) {
      std::error_code none;
      const std::filesystem::path written = std::filesystem::path(folder) / name;
      if (!input.empty() && std::filesystem::equivalent(input, written, none))
        throw vehicle::Error(fmt::format(
            "{}: is read, and -o {} would overwrite it; choose another folder", input, folder));
    }
}

void remove_corrected_of_others(const std::string& folder) {
  const auto ours = base::files_of_set(folder);
  for (const std::string& name : corrected_names())
    if (ours && !ours->contains(name))
      std::filesystem::remove(std::filesystem::path(folder) / name);
}

void write_car(const CorrectedCar& car, const std::string& folder) {
  for (const auto& [name, text] : car.files) base::write_file(folder + "/" + name, text);
  base::write_file(folder + "/vehicle.yaml", car.vehicle_yaml);
}

CorrectedFiles write_corrected(const ExplainRequest& request, const std::string& folder,
                               const StatedRoad& stated, const vehicle::Vehicle& car,
                               const Recordings& recordings, const Findings& findings) {
  CorrectedFiles out{
      request.track_path, request.friction_path, request.vehicle_path, request.mapping_path, {},
      request.fuel_kg};
  const crg::Crg& road = stated.surface.file();
  const CorrectedInputs made = correct({road, stated.friction ? &*stated.friction : nullptr,
                                        request.vehicle_path, car, recordings.recorded},
                                       findings, recordings.logs);
  if (made.road) {
    out.track_path = folder + "/track.crg";
    base::write_file(out.track_path, crg::to_bytes(*made.road, road.format));
  }
  if (made.friction) {
    out.friction_path = folder + "/friction.crg";
    base::write_file(out.friction_path, crg::to_bytes(*made.friction, road.format));
  }
  if (made.car) {
    out.vehicle_path = folder + "/vehicle.yaml";
    write_car(*made.car, folder);
    if (made.car->fuel_kg > 0) out.fuel_kg = made.car->fuel_kg;
  }
  if (made.mapping) {
    out.mapping = made.mapping;
    out.mapping_path = folder + "/mapping.yaml";
    base::write_file(out.mapping_path, format_mapping(as_given(*made.mapping, recordings.given)));
  }
  return out;
}

}  // namespace explain
