#include "cloud/refine.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "cloud/base_road.h"
#include "cloud/error.h"
#include "cloud/map.h"
#include "cloud/map_inputs.h"
#include "cloud/map_scans.h"

namespace cloud {
namespace {

/// Without a base: a first road along the given line or the trajectory's first lap.
crg::Crg road_from_points(const RefineRequest& request, const CloudSource& source,
                          const Trajectory* trajectory) {
  BaseRoadOptions options;
  options.v_max_m = request.v_max_m, options.u_step_m = options.v_step_m = request.node_m,
  options.threads = request.threads;
  if (!request.centreline.empty())
    return base_from_points(source, road::read_centreline_csv(request.centreline), trajectory,
                            options);
  if (trajectory == nullptr)
    throw Error(
        "a road to refine (--road), or a line to make one along (--centreline, or the --trajectory "
        "of the scans) is wanted");
  return base_from_points(source, driven_line(*trajectory), trajectory, options);
}

/// Where a stage of the map ends that begins at `begin`, as shares of its way: those that read the
/// scans take their time.
double end_of_stage(const std::string& name, double begin) {
  if (name == "look at the points") return 0.25;
  if (name == "look at the straightened points") return 0.5;
  if (name == "look at the points turned back") return 0.6;
  if (name == "heights of the nodes" || name == "heights of the older ground") return 0.9;
  return begin;
}

/// What the command line refuses as well.
void want_bounds(const RefineRequest& request) {
  const auto within = [](const char* name, double value, const Bounds& bounds) {
    if (!(value >= bounds.least && value <= bounds.most))
      throw Error(fmt::format("{}: {:g} seen, {:g} to {:g} wanted", name, value, bounds.least,
                              bounds.most));
  };
  const auto word = [](const char* name, const std::string& value,
                       std::initializer_list<const char*> words) {
    if (!value.empty() && std::find(words.begin(), words.end(), value) == words.end())
      throw Error(fmt::format("{}: '{}' seen, one of {} wanted", name, value,
                              fmt::join(words.begin(), words.end(), ", ")));
  };
  if (request.scans.empty()) throw Error("no scan is given; clouds or folders of them are wanted");
  word("--frame", request.frame, {"sensor", "map"});
  word("--cloud-unit", request.unit, {"m", "ft", "us-ft", "cm", "mm"});
  word("--unit", request.base_unit, {"m", "cm", "mm", "ft", "inch", "yard"});
  word("--up", request.base_up, {"x", "y", "z", "-x", "-y", "-z"});
  if (request.format.empty()) throw Error("--format: nothing seen, ply, stl or pcd wanted");
  for (const std::string& format : request.format) word("--format", format, {"ply", "stl", "pcd"});
  if (request.max_range_m) within("--max-range-m", *request.max_range_m, kMaxRangeM);
  if (request.voxel_m != 0.0) within("--voxel-m", request.voxel_m, kVoxelM);
  within("--drift-m", request.drift_m, kDriftM);
  within("--drift-rad", request.drift_rad, kDriftRad);
  within("--v-max-m", request.v_max_m, kVMaxM);
  within("--step-m", request.node_m, kNodeM);
  within("--base-stddev-m", request.base_stddev_m, kBaseStddevM);
  within("--gate-m", request.gate_m, kGateM);
  within("--edge-m", request.edge_m, kEdgeM);
  within("--min-points", request.min_points, {kLeastMinPoints, kMostMinPoints});
  const bool six = request.extrinsic.size() == 6 &&
                   std::all_of(request.extrinsic.begin(), request.extrinsic.end(),
                               [](double value) { return std::isfinite(value); });
  if (!request.extrinsic.empty() && !six)
    throw Error("--extrinsic: six numbers wanted: x y z (m) roll pitch yaw (deg)");
  if (!request.base.empty() && !request.centreline.empty())
    throw Error("--centreline excludes --road: the line of the base is taken");
}

}  // namespace

Refined refine(const RefineRequest& request, const base::Progress& given) {
  const base::Progress progress = given ? given : [](const std::string&, double) {};
  want_bounds(request);
  const bool in_map = points_lie_in_map(request), with_base = !request.base.empty();
  const std::vector<std::string> files = scan_files(request);
  std::vector<road::InputFile> inputs = inputs_of(request, in_map);
  Trajectory trajectory;
  if (!in_map) trajectory = read_trajectory(request.trajectory, sensor_in_poses(request.extrinsic));
  const Trajectory* const poses = in_map ? nullptr : &trajectory;
  const FilterOptions filter = filter_options(request.outliers, request.voxel_m);
  base::OutputSet outputs(request.output_dir, "lidar2mesh map");

  MapScans scans(request, files, progress);
  FilterReport left_out;
  const CloudSource source =
      filter.wanted() ? filtered(scans.source(), poses, filter, &left_out) : scans.source();
  const double first = with_base ? 0.0 : 0.15;  // share of the way
  scans.enter("look for the road", 0.0, first);
  const crg::Crg base =
      with_base ? read_base(request, inputs) : road_from_points(request, source, poses);
  MapOptions options = map_options(request);
  options.progress = [&](const std::string& stage, double share) {
    const double begin = first + (1.0 - first) * share;
    scans.enter(stage, begin, first + (1.0 - first) * end_of_stage(stage, share));
    progress(stage, begin);
  };
  options.on_chunk = [&] { scans.tell(); };
  const MapResult result = with_base ? map_clouds(source, base, poses, options)
                                     : map_without_base(source, base, poses, options);
  return write_refined(request, base, result, remarks_of(scans.remarks(), filter, left_out), inputs,
                       outputs, progress);
}

}  // namespace cloud
