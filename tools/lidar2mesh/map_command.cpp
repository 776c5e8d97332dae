#include <fmt/format.h>

#include "base/ending.h"
#include "base/output_set.h"
#include "cloud/base_road.h"
#include "cloud/error.h"
#include "cloud/map.h"
#include "commands.h"
#include "crg/options.h"
#include "map_scans.h"
#include "road/build.h"
#include "write_map.h"

namespace lidar2mesh {
namespace {

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

/// The base as a road file: read, or built from a mesh without kerb columns or smoothing.
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

/// Without a base: a first road along the given line or the trajectory's first lap.
crg::Crg road_from_points(const MapCommand& command, const cloud::CloudSource& source,
                          const cloud::Trajectory* trajectory) {
  cloud::BaseRoadOptions options;
  options.v_max_m = command.v_max_m, options.u_step_m = options.v_step_m = command.node_m,
  options.threads = command.threads;
  if (!command.centreline.empty())
    return cloud::base_from_points(source, road::read_centreline_csv(command.centreline),
                                   trajectory, options);
  if (trajectory == nullptr)
    throw cloud::Error(
        "a road to refine (--base), or a line to make one along (--centreline, or the --trajectory "
        "of the scans) is wanted");
  return cloud::base_from_points(source, cloud::driven_line(*trajectory), trajectory, options);
}

cloud::MapOptions map_options(const MapCommand& command) {
  cloud::MapOptions options;
  options.base_stddev_m = command.base_stddev_m, options.drift_m_per_100m = command.drift_m,
  options.drift_rad_per_100m = command.drift_rad;
  options.min_points = command.min_points, options.gate_m = command.gate_m,
  options.correct_drift = command.correct_drift, options.threads = command.threads;
  return options;
}

/// Where a stage of the map ends that begins at `begin`, as shares of its way: those that read the
/// scans take their time.
double end_of_stage(const std::string& name, double begin) {
  if (name == "look at the points") return 0.25;
  if (name == "look at the straightened points") return 0.6;
  if (name == "heights of the nodes") return 0.9;
  return begin;
}

/// What the map says, then what was seen in the scans and left out of them.
cloud::MapReport with_remarks(cloud::MapReport facts, const std::vector<std::string>& of_scans,
                              const cloud::FilterOptions& filter,
                              const cloud::FilterReport& left_out) {
  facts.remarks.insert(facts.remarks.end(), of_scans.begin(), of_scans.end());
  if (filter.wanted())
    facts.remarks.push_back(
        fmt::format("of {} points {} were taken out as outliers and {} by thinning",
                    left_out.points, left_out.outliers, left_out.thinned));
  return facts;
}

}  // namespace

int run_map(const MapCommand& command, Terminal& terminal) {
  const bool in_map = points_lie_in_map(command), with_base = !command.base.empty();
  const std::vector<std::string> files = scan_files(command);
  std::vector<road::InputFile> inputs = inputs_of(command, in_map);
  cloud::Trajectory trajectory;
  if (!in_map)
    trajectory = cloud::read_trajectory(command.trajectory, sensor_in_poses(command.extrinsic));
  const cloud::Trajectory* const poses = in_map ? nullptr : &trajectory;
  const cloud::FilterOptions filter = filter_options(command.outliers, command.voxel_m);
  base::OutputSet outputs(command.output_dir, "lidar2mesh map");

  const base::Progress progress = terminal.progress();
  MapScans scans(command, files, progress);
  cloud::FilterReport left_out;
  const cloud::CloudSource source =
      filter.wanted() ? cloud::filtered(scans.source(), poses, filter, &left_out) : scans.source();
  const double first = with_base ? 0.0 : 0.15;  // share of the way
  scans.enter("look for the road", 0.0, first);
  const crg::Crg base =
      with_base ? read_base(command, inputs) : road_from_points(command, source, poses);
  cloud::MapOptions options = map_options(command);
  options.progress = [&](const std::string& stage, double share) {
    const double begin = first + (1.0 - first) * share;
    scans.enter(stage, begin, first + (1.0 - first) * end_of_stage(stage, share));
    progress(stage, begin);
  };
  const cloud::MapResult result = with_base ? cloud::map_clouds(source, base, poses, options)
                                            : cloud::map_without_base(source, base, poses, options);
  const cloud::MapReport facts = with_remarks(result.report, scans.remarks(), filter, left_out);

  const std::string summary = write_map(command, base, result, facts, inputs, outputs, terminal);
  outputs.commit("refined", {}, {"timing.json"});
  if (terminal.json)
    terminal.print(summary);
  else
    print_result(command, facts, outputs, terminal);
  if (!facts.faults.empty())
    throw command::NotValid(
        fmt::format("{}: {}; do not use this road", outputs.path("refined.crg"),
                    one_line(fmt::format("{}", fmt::join(facts.faults, "; ")))));
  return kOk;
}

}  // namespace lidar2mesh
