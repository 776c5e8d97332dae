#include <fmt/format.h>

#include <filesystem>

#include "base/ending.h"
#include "base/json_text.h"
#include "base/output_set.h"
#include "base/write_file.h"
#include "cloud/base_road.h"
#include "cloud/error.h"
#include "cloud/map.h"
#include "cloud/write_surface.h"
#include "commands.h"
#include "crg/options.h"
#include "map_report.h"
#include "road/build.h"

namespace lidar2mesh {
namespace {

namespace fs = std::filesystem;
constexpr double kDegree = 0.017453292519943295;

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

/// The points no farther from the sensor than this.
cloud::Cloud within(cloud::Cloud&& cloud, double range_m) {
  std::size_t kept = 0;
  const auto keep = [&](auto& values, std::size_t k) {
    if (!values.empty()) values[kept] = values[k];
  };
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    if (!((cloud.origin_m + cloud.point(k)).norm() <= range_m)) continue;
    keep(cloud.x_m, k), keep(cloud.y_m, k), keep(cloud.z_m, k);
    keep(cloud.time_s, k), keep(cloud.intensity, k), keep(cloud.classification, k);
    ++kept;
  }
  const auto cut = [&](auto& values) {
    if (!values.empty()) values.resize(kept);
  };
  cut(cloud.time_s), cut(cloud.intensity), cut(cloud.classification);
  cut(cloud.x_m), cut(cloud.y_m), cut(cloud.z_m);
  return std::move(cloud);
}

/// As triangles, for a file that carries nothing else.
road::Mesh mesh_of(const cloud::NodeSurface& surface) {
  road::Mesh mesh;
  mesh.origin_m = surface.origin_m, mesh.vertices_m = surface.place_m;
  mesh.triangles = surface.triangles;
  mesh.object_of_triangle.assign(mesh.triangles.size(), 0);
  mesh.objects.push_back({"road", "road", ""});
  return mesh;
}

/// refined.ply or .stl, and refined.pcd where it is wanted.
void write_surfaces(const MapCommand& command, const cloud::NodeSurface& surface,
                    const std::vector<road::InputFile>& inputs, const base::OutputSet& outputs) {
  const std::vector<std::string> comments = comments_of(inputs, command.options);
  if (command.stl)
    road::write_mesh(mesh_of(surface), outputs.staged("refined.stl"));
  else
    cloud::write_surface(surface, outputs.staged("refined.ply"), command.doubles, comments);
  if (command.pcd)
    cloud::write_surface(surface, outputs.staged("refined.pcd"), command.doubles, comments);
}

void print_result(const MapCommand& command, const cloud::MapReport& facts,
                  const base::OutputSet& outputs, Terminal& terminal) {
  terminal.print(fmt::format("{} points read, {} used; {:.1f} % of the nodes come from points\n",
                             facts.points, facts.used, 100.0 * facts.coverage));
  if (command.correct_drift) {
    terminal.print(
        fmt::format("drift: {} after {} rounds over {} sections in {} passes\n",
                    facts.converged ? "converged"
                    : command.base.empty()
                        ? fmt::format("still moving by {:.1f} mm a round", 1e3 * facts.last_move_m)
                        : "NOT converged",
                    facts.iterations, facts.sections, facts.passes));
    if (command.base.empty())
      terminal.print(
          fmt::format("where the road lies is the trajectory's word: about {:.0f} mm in height\n",
                      1e3 * facts.typical_stddev[2]));
    if (!command.base.empty())
      terminal.print(fmt::format(
          "against the base {:.1f} -> {:.1f} mm, {:.0f} % of its cells believed\n",
          1e3 * facts.rms_before_m, 1e3 * facts.rms_after_m, 100.0 * facts.inlier_share));
    if (facts.passes > 1)
      terminal.print(fmt::format("between passes {:.1f} -> {:.1f} mm\n",
                                 1e3 * facts.pass_rms_before_m, 1e3 * facts.pass_rms_after_m));
    for (const std::string& direction : facts.unfixed)
      terminal.print(fmt::format(
          "note: {} is hardly fixed by the data (typical deviation in summary.json)\n", direction));
  }
  terminal.print(
      fmt::format("heights changed by {:.1f} mm (median), {:.1f} mm (99 %), {:.1f} mm at most\n",
                  1e3 * facts.changed_p50_m, 1e3 * facts.changed_p99_m, 1e3 * facts.changed_max_m));
  for (const std::string& remark : facts.remarks)
    terminal.print(fmt::format("note: {}\n", one_line(remark)));
  terminal.print(fmt::format("road     {}\nsummary  {}\n", outputs.path("refined.crg"),
                             outputs.path("summary.json")));
}

}  // namespace

int run_map(const MapCommand& command, Terminal& terminal) {
  const bool in_map =
      command.frame == "map" || (command.frame.empty() && command.trajectory.empty());
  if (!in_map && command.trajectory.empty())
    throw cloud::Error("points in the sensor's frame need a trajectory: --trajectory T.csv");
  if (in_map && command.max_range_m)
    throw cloud::Error(
        "--max-range-m wants points in the sensor's frame: those in the map frame do not say from "
        "where they were measured");
  std::vector<std::string> files;
  for (const std::string& scan : command.scans)
    for (const std::string& file : cloud::cloud_files(scan)) files.push_back(file);
  std::vector<road::InputFile> inputs;
  const auto add_inputs = [&](const char* role, const std::string& path) {
    for (const road::InputFile& file : hashed(role, path)) inputs.push_back(file);
  };
  for (const std::string& scan : command.scans) add_inputs("scan", scan);
  if (!in_map) add_inputs("trajectory", command.trajectory);
  add_inputs("base", command.base);
  add_inputs("centreline", command.centreline);
  cloud::CloudReadOptions read;
  read.metres_per_unit = metres_per_unit(command.unit);
  cloud::Trajectory trajectory;
  if (!in_map) {
    Eigen::Isometry3d extrinsic = Eigen::Isometry3d::Identity();
    if (command.extrinsic.size() == 6) {
      const std::vector<double>& e = command.extrinsic;
      extrinsic = Eigen::Translation3d(e[0], e[1], e[2]) *
                  Eigen::AngleAxisd(e[5] * kDegree, Eigen::Vector3d::UnitZ()) *
                  Eigen::AngleAxisd(e[4] * kDegree, Eigen::Vector3d::UnitY()) *
                  Eigen::AngleAxisd(e[3] * kDegree, Eigen::Vector3d::UnitX());
    }
    trajectory = cloud::read_trajectory(command.trajectory, extrinsic);
  }
  const cloud::FilterOptions filter = filter_options(command.outliers, command.voxel_m);
  base::OutputSet outputs(command.output_dir, "lidar2mesh map");
  // Within a stage that reads the scans, the share of the whole follows their bytes.
  std::string stage = "look for the road";
  double stage_begin = 0.0, stage_end = command.base.empty() ? 0.15 : 0.0;
  const base::Progress progress = terminal.progress();
  double bytes_in_all = 0.0, bytes_before = 0.0, bytes_here = 0.0;
  for (const std::string& file : files) bytes_in_all += static_cast<double>(fs::file_size(file));
  read.progress = [&](double share) {
    const double done = (bytes_before + share * bytes_here) / bytes_in_all;
    progress(stage, stage_begin + (stage_end - stage_begin) * done);
  };
  std::vector<std::string> remarks;
  const cloud::CloudSource scans = [&](const cloud::ChunkSink& sink) {
    remarks.clear();
    bytes_before = 0.0;
    for (const std::string& file : files) {
      bytes_here = static_cast<double>(fs::file_size(file));
      const auto near = [&](cloud::Cloud&& chunk) {
        if (command.max_range_m) chunk = within(std::move(chunk), *command.max_range_m);
        if (chunk.size() > 0) sink(std::move(chunk));
      };
      for (const std::string& remark : cloud::read_chunks(file, read, near).remarks)
        remarks.push_back(file + ": " + remark);
      bytes_before += bytes_here;
    }
  };
  const cloud::Trajectory* const poses = in_map ? nullptr : &trajectory;
  cloud::FilterReport left_out;
  const cloud::CloudSource source =
      filter.wanted() ? cloud::filtered(scans, poses, filter, &left_out) : scans;
  const crg::Crg base =
      command.base.empty() ? road_from_points(command, source, poses) : read_base(command, inputs);
  cloud::MapOptions options;
  options.base_stddev_m = command.base_stddev_m, options.drift_m_per_100m = command.drift_m,
  options.drift_rad_per_100m = command.drift_rad;
  options.min_points = command.min_points, options.gate_m = command.gate_m,
  options.correct_drift = command.correct_drift, options.threads = command.threads;
  const double first = stage_end;  // share of the way without a base
  options.progress = [&, first](const std::string& name, double share) {
    stage = name;
    const double end = name == "look at the points"                ? 0.25
                       : name == "look at the straightened points" ? 0.6
                       : name == "heights of the nodes"            ? 0.9
                                                                   : share;
    stage_begin = first + (1.0 - first) * share;
    stage_end = first + (1.0 - first) * end;
    progress(stage, stage_begin);
  };
  const cloud::MapResult result = command.base.empty()
                                      ? cloud::map_without_base(source, base, poses, options)
                                      : cloud::map_clouds(source, base, poses, options);

  const auto path = [&](const char* name) { return outputs.staged(name); };
  const auto with_grid = [&](const crg::Grid& grid, bool heights) {
    crg::Crg file = base;
    file.grid = grid;
    file.z_double_m.clear();
    if (!heights) file.banking.clear(), file.slope.clear();
    if (!heights)
      for (const char* key : {"REFERENCE_LINE_START_Z", "REFERENCE_LINE_END_Z"})
        crg::set_value(file.road, key, 0.0);
    return file;
  };
  const crg::Crg refined = with_grid(result.grid, true);
  base::write_file(path("refined.crg"), crg::to_bytes(refined, crg::Format::KRBI));
  base::write_file(path("refined.stddev.crg"),
                   crg::to_bytes(with_grid(result.stddev, false), crg::Format::KRBI));
  base::write_file(path("refined.provenance.crg"),
                   crg::to_bytes(with_grid(result.source, false), crg::Format::KRBI));
  const cloud::NodeSurface surface = cloud::node_surface(refined, result.stddev);
  write_surfaces(command, surface, inputs, outputs);
  cloud::MapReport facts = result.report;
  facts.remarks.insert(facts.remarks.end(), remarks.begin(), remarks.end());
  if (filter.wanted())
    facts.remarks.push_back(
        fmt::format("of {} points {} were taken out as outliers and {} by thinning",
                    left_out.points, left_out.outliers, left_out.thinned));
  nlohmann::ordered_json out = head_of(inputs, command.options);
  if (!command.doubles)
    out["origin_m"] = {surface.origin_m.x(), surface.origin_m.y(), surface.origin_m.z()};
  out.update(nlohmann::ordered_json::parse(cloud::map_summary_json(facts)));
  const std::string summary = base::json_text(out);
  base::write_file(path("summary.json"), summary);
  base::write_file(path("timing.json"), cloud::map_timing_json(facts));
  if (!result.corrected.empty())
    cloud::write_trajectory(result.corrected.front(), path("trajectory.csv"));
  if (command.report) {
    terminal.progress()("report", 0.95);
    base::write_file(path("base.crg"), crg::to_bytes(base, crg::Format::KRBI));
    write_map_report(outputs, base, refined, result.source, facts, inputs, command.threads);
  }
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
