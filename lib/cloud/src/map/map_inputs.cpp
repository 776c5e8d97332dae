#include "cloud/map_inputs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "base/ending.h"
#include "cloud/error.h"
#include "cloud/pcl.h"
#include "crg/options.h"
#include "mesh/read_mesh.h"
#include "road/clean.h"
#include "road/reference_line.h"
#include "road/sample.h"
#include "road/track_crg.h"

namespace cloud {

std::vector<road::InputFile> inputs_of(const RefineRequest& request, bool in_map) {
  std::vector<road::InputFile> inputs;
  const auto add = [&](const char* role, const std::string& path) {
    for (const road::InputFile& file : hashed(role, path)) inputs.push_back(file);
  };
  for (const std::string& scan : request.scans) add("scan", scan);
  if (!in_map) add("trajectory", request.trajectory);
  add("base", request.base);
  add("centreline", request.centreline);
  return inputs;
}

crg::Crg read_base(const RefineRequest& request, std::vector<road::InputFile>& inputs) {
  if (base::ending_of(request.base) == ".crg") return crg::apply_modifiers(crg::read(request.base));
  road::MeshReadOptions read;
  read.up = road::up_called(request.base_up);
  read.mirror = request.base_mirror;
  read.unit = road::unit_called(request.base_unit);
  read.allow_outside = request.allow_outside;
  road::MeshReadReport report;
  const road::Mesh raw = road::read_mesh(request.base, read, &report);
  for (const road::MeshFile& file : report.files)
    inputs.push_back({road::kMeshFile, file.path, file.sha256});
  const road::RoadMesh mesh = road::clean(raw);
  const road::Centreline centreline = road::trace_centreline(mesh);
  const crg::ReferenceLine line = road::fit_reference_line(centreline);
  return road::track_crg(
      line, road::sample_grid(mesh, road::RaySurface(mesh.mesh), line, centreline).grid);
}

MapOptions map_options(const RefineRequest& request) {
  MapOptions options;
  options.base_stddev_m = request.base_stddev_m, options.drift_m_per_100m = request.drift_m,
  options.drift_rad_per_100m = request.drift_rad;
  options.min_points = request.min_points, options.gate_m = request.gate_m,
  options.edge_m = request.no_grass ? std::numeric_limits<double>::infinity() : request.edge_m,
  options.correct_drift = request.correct_drift, options.threads = request.threads;
  options.keep_older = request.campaigns;
  return options;
}

void want_outliers(const std::vector<double>& outliers) {
  if (outliers.empty()) return;
  const double n = outliers.front(), deviations = outliers.size() == 2 ? outliers.back() : 0.0;
  if (!(n >= 2.0 && n <= 1000.0 && n == std::floor(n) && deviations > 0.0 && deviations < 1e6))
    throw Error(fmt::format(
        "--outliers {:g} seen; a whole number of neighbours, 2 to 1000, and deviations above "
        "0 wanted, e.g. 20 2",
        fmt::join(outliers, " ")));
}

FilterOptions filter_options(const std::vector<double>& outliers, double voxel_m) {
  FilterOptions options;
  options.voxel_m = voxel_m;
  if (voxel_m > 0.0) require_pcl("--voxel-m");
  want_outliers(outliers);
  if (outliers.empty()) return options;
  require_pcl("--outliers");
  options.outlier_neighbours = static_cast<int>(outliers[0]), options.outlier_sigma = outliers[1];
  return options;
}

std::vector<std::string> remarks_of(const std::vector<std::string>& of_scans,
                                    const FilterOptions& filter, const FilterReport& left_out) {
  std::vector<std::string> remarks = of_scans;
  if (filter.wanted())
    remarks.push_back(fmt::format("of {} points {} were taken out as outliers and {} by thinning",
                                  left_out.points, left_out.outliers, left_out.thinned));
  return remarks;
}

}  // namespace cloud
