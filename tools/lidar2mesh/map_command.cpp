#include "base/output_set.h"
#include "cloud/base_road.h"
#include "cloud/error.h"
#include "cloud/map.h"
#include "commands.h"
#include "map_inputs.h"
#include "map_scans.h"
#include "write_map.h"

namespace lidar2mesh {
namespace {

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

/// Where a stage of the map ends that begins at `begin`, as shares of its way: those that read the
/// scans take their time.
double end_of_stage(const std::string& name, double begin) {
  if (name == "look at the points") return 0.25;
  if (name == "look at the straightened points") return 0.6;
  if (name == "heights of the nodes") return 0.9;
  return begin;
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
  return hand_out_map(command, base, result, remarks_of(scans.remarks(), filter, left_out), inputs,
                      outputs, terminal);
}

}  // namespace lidar2mesh
