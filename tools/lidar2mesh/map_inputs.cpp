#include "map_inputs.h"

#include <fmt/format.h>

#include "base/ending.h"
#include "crg/options.h"
#include "road/build.h"

namespace lidar2mesh {

std::vector<road::InputFile> inputs_of(const MapCommand& command, bool in_map) {
  std::vector<road::InputFile> inputs;
  const auto add = [&](const char* role, const std::string& path) {
    for (const road::InputFile& file : hashed(role, path)) inputs.push_back(file);
  };
  for (const std::string& scan : command.scans) add("scan", scan);
  if (!in_map) add("trajectory", command.trajectory);
  add("base", command.base);
  add("centreline", command.centreline);
  return inputs;
}

crg::Crg read_base(const MapCommand& command, std::vector<road::InputFile>& inputs) {
  if (base::ending_of(command.base) == ".crg") return crg::apply_modifiers(crg::read(command.base));
  road::MeshReadOptions read;
  if (command.base_up == "y") read.up = road::UpAxis::y;
  if (command.base_up == "z") read.up = road::UpAxis::z;
  read.unit = road::unit_called(command.base_unit);
  read.allow_outside = command.allow_outside;
  road::MeshReadReport report;
  const road::Mesh raw = road::read_mesh(command.base, read, &report);
  for (const road::MeshFile& file : report.files)
    inputs.push_back({road::kMeshFile, file.path, file.sha256});
  const road::RoadMesh mesh = road::clean(raw);
  const road::Centreline centreline = road::trace_centreline(mesh);
  const crg::ReferenceLine line = road::fit_reference_line(centreline);
  return road::track_crg(
      line, road::sample_grid(mesh, road::RaySurface(mesh.mesh), line, centreline).grid);
}

cloud::MapOptions map_options(const MapCommand& command) {
  cloud::MapOptions options;
  options.base_stddev_m = command.base_stddev_m, options.drift_m_per_100m = command.drift_m,
  options.drift_rad_per_100m = command.drift_rad;
  options.min_points = command.min_points, options.gate_m = command.gate_m,
  options.correct_drift = command.correct_drift, options.threads = command.threads;
  return options;
}

std::vector<std::string> remarks_of(const std::vector<std::string>& of_scans,
                                    const cloud::FilterOptions& filter,
                                    const cloud::FilterReport& left_out) {
  std::vector<std::string> remarks = of_scans;
  if (filter.wanted())
    remarks.push_back(fmt::format("of {} points {} were taken out as outliers and {} by thinning",
                                  left_out.points, left_out.outliers, left_out.thinned));
  return remarks;
}

}  // namespace lidar2mesh
