// Options in, one command, exit code.
#include <algorithm>
#include <functional>
#include <string>

#include "cloud/pcl.h"
#include "command/program.h"
#include "commands.h"

namespace lidar2mesh {
namespace {

using command::add_choice, command::add_input, command::add_output_file, command::add_output_folder;

using std::string_literals::operator""s;

using Run = std::function<int()>;

CLI::Option* add_unit(CLI::App& app, std::string& unit) {
  return add_choice(app, "--unit", unit, "of the cloud [as the file says, else m]",
                    {"m", "ft", "us-ft", "cm", "mm"});
}

void add_doubles(CLI::App& app, bool& doubles) {
  app.add_flag(
      "--doubles", doubles,
      "write coordinates in double, in the map frame [float32, relative to the origin_m in the "
      "header]");
}

void add_outliers(CLI::App& app, std::vector<double>& outliers) {
  app.add_option("--outliers", outliers,
                 "take points out whose mean distance to their N neighbours is S deviations above "
                 "the mean, N S, e.g. 20 2 (PCL) [none]")
      ->expected(2);
}

/// What the help and --version say about PCL.
std::string about_pcl() {
  if (const std::string version = cloud::pcl_version(); !version.empty())
    return "with PCL " + version;
  return "without PCL, for which libpcl-dev must be installed when it is built: --method gicp, "
         "--coarse and --outliers of register, --method pmf of ground, --outliers of map, "
         "--voxel-m of map and changes are missing";
}

void define_info(CLI::App& app, InfoCommand& c, Terminal& terminal, Run& run) {
  CLI::App* const info =
      app.add_subcommand("info", "points, bounds, unit, classes and resolution of a cloud");
  add_input(*info, "cloud", c.cloud,
            "a .las, .laz, .ply, .pcd, .bin, .xyz or .csv, or a folder of them",
            command::kFileOrFolder)
      ->required();
  add_unit(*info, c.unit);
  info->footer(
      "With --json: an object for a file, an array of them for a folder.\n\n"
      "Example:\n  lidar2mesh info survey.las");
  info->callback([&] { run = [&] { return run_info(c, terminal); }; });
}

void define_ground(CLI::App& app, GroundCommand& c, Terminal& terminal, Run& run) {
  CLI::App* const ground =
      app.add_subcommand("ground", "tells ground from buildings, cars and trees");
  add_input(*ground, "cloud", c.cloud, "in the map frame")->required();
  add_output_file(*ground, c.output, "the cloud with classes: 2 ground, 1 other; .ply or .pcd")
      ->required();
  add_doubles(*ground, c.doubles);
  add_unit(*ground, c.unit);
  add_choice(*ground, "--method", c.method,
             "our own, or PCL's progressive morphological filter, exact or on a grid [own]",
             {"own", "pmf", "pmf-grid"});
  ground->add_option("--cell-m", c.cell_m, "of the surface of lowest points [1]")
      ->check(CLI::Range(0.05, 100.0));
  ground->add_option("--window-m", c.window_m, "radius of the largest object [18; pmf: 10]")
      ->check(CLI::Range(0.1, 500.0));
  ground->add_option("--slope", c.slope, "steepest ground, m/m [0.15; pmf: 1]")
      ->check(CLI::Range(0.001, 5.0));
  ground->add_option("--height-m", c.height_m, "of ground points above the surface [0.5]")
      ->check(CLI::Range(0.01, 10.0));
  ground->footer("Example:\n  lidar2mesh ground survey.las -o ground.ply");
  ground->callback([&, ground] {
    c.options = command::options_used(*ground);
    run = [&] { return run_ground(c, terminal); };
  });
}

void define_register(CLI::App& app, RegisterCommand& c, Terminal& terminal, Run& run) {
  CLI::App* const reg = app.add_subcommand("register", "finds how a cloud lies to another");
  add_input(*reg, "target", c.target, "the cloud that stays")->required();
  add_input(*reg, "source", c.source, "the cloud that moves")->required();
  add_output_file(*reg, c.output, "the moved source, .ply or .pcd");
  add_doubles(*reg, c.doubles);
  add_unit(*reg, c.unit);
  reg->add_option("--voxel-m", c.voxel_m, "both are thinned to one point per such cube [0.25]")
      ->check(CLI::Range(0.01, 10.0));
  reg->add_option("--reach-m", c.reach_m, "how far off the source may be [2]")
      ->check(CLI::Range(0.05, 100.0));
  add_choice(*reg, "--method", c.method,
             "our own; robust: it ends with pairs within two cubes, and what moved loses its pull; "
             "or PCL's generalised ICP [own]",
             {"own", "robust", "gicp"});
  command::hide_old(reg->add_flag("--robust", c.robust), "--method robust");
  reg->add_flag(
      "--coarse", c.coarse,
      "begin without a guess: shapes of both clouds are paired (PCL); --reach-m holds after it");
  add_outliers(*reg, c.outliers);
  reg->add_option("--seed", c.seed, "of --coarse [1]");
  reg->add_option("--threads", c.threads, "[all cores]");
  reg->footer(
      "Example:\n  lidar2mesh register monday.ply tuesday.ply -o moved.ply\n\nExit code 3 when it "
      "did not converge.");
  reg->callback([&, reg] {
    c.options = command::options_used(*reg);
    run = [&] { return run_register(c, terminal); };
  });
}

void define_changes(CLI::App& app, ChangesCommand& c, Terminal& terminal, Run& run) {
  CLI::App* const changes =
      app.add_subcommand("changes", "what changed between two campaigns, as a list and a map");
  add_input(*changes, "old", c.before, "a cloud in the map frame, or a folder of them",
            command::kFileOrFolder)
      ->required();
  add_input(*changes, "new", c.after, "the same, later", command::kFileOrFolder)->required();
  add_output_folder(*changes, c.output_dir, "folder for the results, made if missing")->required();
  add_unit(*changes, c.unit);
  changes
      ->add_option("--cell-m", c.cell_m,
                   "side of the cells that are compared [as the points allow]")
      ->check(CLI::Range(0.05, 100.0));
  changes->add_option("--min-change-m", c.min_change_m, "smallest change that is told [0.01]")
      ->check(CLI::Range(1e-4, 10.0));
  changes
      ->add_option(
          "--window-m", c.level_m,
          "differences that are even over this width are drift and taken out; 0: none [30]")
      ->check(CLI::Range(0.0, 10000.0));
  changes
      ->add_option("--voxel-m", c.octree_m,
                   "also cubes of this side with points of one campaign alone (PCL) [none]")
      ->check(CLI::Range(0.05, 100.0));
  changes->footer("Example:\n  lidar2mesh changes spring.las autumn.las -o changed");
  changes->callback([&] { run = [&] { return run_changes(c, terminal); }; });
}

void define_tiles(CLI::App& app, TilesCommand& c, Terminal& terminal, Run& run) {
  CLI::App* const tiles =
      app.add_subcommand("tiles", "levels of detail of a cloud of any size, for 'kerbstone view'");
  add_input(*tiles, "cloud", c.clouds, "clouds, or folders of them", command::kFileOrFolder)
      ->required();
  add_output_folder(*tiles, c.output_dir, "folder for the tiles, made if missing")->required();
  add_input(*tiles, "--trajectory", c.trajectory,
            "poses of the sensor, for points in its frame: CSV time_s,x_m,y_m,z_m,qx,qy,qz,qw");
  tiles
      ->add_option("--extrinsic", c.extrinsic,
                   "the sensor in the frame of the poses: x y z (m) roll pitch yaw (deg)")
      ->expected(6);
  add_unit(*tiles, c.unit);
  tiles->add_option("--threads", c.threads, "[all cores]; any number gives the same bytes");
  tiles->footer("Example:\n  lidar2mesh tiles survey.las -o survey-tiles");
  tiles->callback([&, tiles] {
    c.options = command::options_used(*tiles);
    run = [&] { return run_tiles(c, terminal); };
  });
}

void define_synth(CLI::App& app, SynthCommand& c, Terminal& terminal, Run& run) {
  CLI::App* const synth =
      app.add_subcommand("synth", "scans of a spinning LiDAR on a car driving a known road");
  add_input(*synth, "road", c.road, "a .crg, or a circuit.yaml as for 'crgbuild synth'")
      ->required();
  add_output_folder(*synth, c.output_dir, "folder for scans, trajectory and truth")->required();
  synth->add_option("--laps", c.laps, "[2]")->check(CLI::Range(1, 100));
  synth->add_option("--u-begin-m", c.u_begin_m, "u where each lap begins, m [0]");
  synth->add_option("--u-end-m", c.u_end_m, "u where each lap ends, m [the road's end]");
  synth->add_option("--v-m", c.v_m, "lateral place of each lap, m [-1.5 1.5]");
  synth->add_option("--speed-mps", c.speed_mps, "[20]")->check(CLI::Range(1.0, 100.0));
  command::hide(synth->add_option("--beams", c.beams)->check(CLI::Range(1, 256)));
  synth->add_option("--azimuths", c.azimuths, "shots of each beam per turn [1024]")
      ->check(CLI::Range(16, 8192));
  synth->add_option("--noise-m", c.noise_m, "standard deviation of ranges [0.005]")
      ->check(CLI::Range(0.0, 1.0));
  synth
      ->add_option("--drift-m", c.drift_m,
                   "change of x, y, z over 100 m, rms [0.05]; --drift-rad: of roll, pitch, yaw "
                   "[0.002]")
      ->check(CLI::Range(0.0, 10.0));
  command::hide(synth->add_option("--drift-rad", c.drift_rad)->check(CLI::Range(0.0, 0.1)));
  synth->add_option("--cars", c.cars, "other cars in view [2]")->check(CLI::Range(0, 20));
  synth->add_option("--grass-m", c.grass_m, "height of grass beyond 8 m from the middle [0]")
      ->check(CLI::Range(0.0, 2.0));
  synth
      ->add_option("--scenery-m", c.scenery_m,
                   "a tree, pole or wall on each side every so many metres, 9 to 11.5 m from the "
                   "middle [none]")
      ->check(CLI::Range(1.0, 1000.0));
  synth->add_option("--seed", c.seed, "[1]");
  synth->add_option("--threads", c.threads, "[all cores]");
  synth->footer(
      "For a circuit.yaml also base.crg: the same without kerbs and bumps, banking 0.006 m/m "
      "off.\n\n"
      "Example:\n  lidar2mesh synth tracks/kerbstone-ring/circuit.yaml -o scans --u-begin-m 380 "
      "--u-end-m 500 --grass-m 0.03 --scenery-m 12");
  synth->callback([&, synth] {
    c.options = command::options_used(*synth);
    run = [&] { return run_synth(c, terminal); };
  });
}

CLI::Range within(const cloud::Bounds& bounds) { return {bounds.least, bounds.most}; }

/// Scans and their trajectory, which is returned.
CLI::Option* add_scans(CLI::App& app, MapCommand& c) {
  add_input(app, "scans", c.scans, "clouds, or folders of them", command::kFileOrFolder)
      ->required();
  return add_input(app, "--trajectory", c.trajectory,
                   "poses of the sensor: CSV time_s,x_m,y_m,z_m,qx,qy,qz,qw");
}

/// How points come to their places, and which of them.
void add_placing(CLI::App& app, MapCommand& c) {
  app.add_option("--extrinsic", c.extrinsic,
                 "the sensor in the frame of the poses: x y z (m) roll pitch yaw (deg)")
      ->expected(6);
  app.add_option("--max-range-m", c.max_range_m,
                 "points farther from the sensor are left out; in its frame only [all are used]")
      ->check(within(cloud::kMaxRangeM));
  app.add_option("--drift-m", c.drift_m,
                 "how fast x, y, z may drift, m per 100 m [0.05]; --drift-rad: roll, pitch, yaw, "
                 "rad per 100 m [0.002]")
      ->check(within(cloud::kDriftM));
  command::hide(app.add_option("--drift-rad", c.drift_rad)->check(within(cloud::kDriftRad)));
  add_outliers(app, c.outliers);
  app.add_option("--voxel-m", c.voxel_m,
                 "thin the scans to one point per such cube (PCL) [not thinned]")
      ->check(within(cloud::kVoxelM));
}

CLI::Option* add_base(CLI::App& app, MapCommand& c) {
  return add_input(app, "--road", c.base, "the road to refine: a .crg, or a mesh");
}

void add_base_or_none(CLI::App& app, MapCommand& c) {
  CLI::Option* const base = add_base(app, c);
  add_input(app, "--centreline", c.centreline,
            "no base: the road is made along this line, CSV x_m,y_m,z_m,half_width_m")
      ->excludes(base);
  app.add_option("--v-max-m", c.v_max_m, "without a base: how far to both sides of the line [10]")
      ->check(within(cloud::kVMaxM))
      ->excludes(base);
  app.add_option("--step-m", c.node_m, "without a base: between the nodes of the road [0.1]")
      ->check(within(cloud::kNodeM))
      ->excludes(base);
}

/// What the base is, and what of the points counts.
void add_fusion(CLI::App& app, MapCommand& c) {
  command::hide(app.add_option("--min-points", c.min_points)
                    ->check(CLI::Range(cloud::kLeastMinPoints, cloud::kMostMinPoints)));
  add_choice(app, "--unit", c.base_unit, "of a base mesh [found]",
             {"m", "cm", "mm", "ft", "inch", "yard"});
  add_choice(app, "--up", c.base_up, "of a base mesh [found]", {"x", "y", "z", "-x", "-y", "-z"});
  app.add_flag("--mirror", c.base_mirror, "reflect the plan of a base mesh");
  app.add_flag("--allow-outside", c.allow_outside, "a base mesh may refer to files elsewhere");
  add_choice(app, "--cloud-unit", c.unit, "of the clouds [as the file says, else m]",
             {"m", "ft", "us-ft", "cm", "mm"});
  app.add_option("--base-stddev-m", c.base_stddev_m, "of the base's heights [0.02]")
      ->check(within(cloud::kBaseStddevM));
  app.add_option(
         "--gate-m", c.gate_m,
         "points farther above or below the base are no road [0.5]; --min-points: with fewer "
         "a node keeps the base, or is a hole [1]")
      ->check(within(cloud::kGateM));
  CLI::Option* const edge =
      app.add_option("--edge-m", c.edge_m, "so far to both sides of the line nothing is grass [0]")
          ->check(within(cloud::kEdgeM));
  app.add_flag("--no-grass", c.no_grass, "nothing is grass, however much it scatters")
      ->excludes(edge);
}

CLI::Option* add_results(CLI::App& app, MapCommand& c, const char* folder) {
  CLI::Option* const output = add_output_folder(app, c.output_dir, folder);
  app.add_option("--format", c.format,
                 "of the refined surface, one or more, ply,pcd: .ply, .stl (float32), or .pcd: the "
                 "nodes with normals and sigma [ply]")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->transform(CLI::IsMember({"ply", "stl", "pcd"}, CLI::ignore_case).description(""))
      ->type_name("ply, stl or pcd");
  command::hide_old(
      app.add_flag_callback(
          "--stl", [&c] { std::replace(c.format.begin(), c.format.end(), "ply"s, "stl"s); }),
      "--format stl");
  command::hide_old(app.add_flag_callback("--pcd", [&c] { c.format.emplace_back("pcd"); }),
                    "--format ply,pcd");
  add_doubles(app, c.doubles);
  app.add_flag("!--no-report", c.report, "leave out report.html and report.json");
  return output;
}

void add_threads(CLI::App& app, unsigned& threads) {
  app.add_option("--threads", threads, "[all cores]; any number gives the same bytes");
}

void define_map(CLI::App& app, MapCommand& c, Terminal& terminal, Run& run) {
  CLI::App* const map =
      app.add_subcommand("map", "refines a road from scans: drift corrected, heights fused");
  add_scans(*map, c);
  add_choice(*map, "--frame", c.frame, "of the points [sensor with a trajectory]",
             {"sensor", "map"});
  add_placing(*map, c);
  add_base_or_none(*map, c);
  add_fusion(*map, c);
  map->add_flag(
      "--campaigns", c.campaigns,
      "ground that changed between passes is no fault: the older is kept, too, with a map");
  add_results(*map, c, "folder for the results, made if missing")->required();
  add_threads(*map, c.threads);
  map->footer(
      "Example:\n  lidar2mesh map scans --trajectory t.csv --road track.crg -o out\n\n"
      "Exit code 3 when the drift from the base did not converge, when the same ground lies at\n"
      "different heights as seen from different places, or when it changed between passes\n"
      "and no --campaigns was given.");
  map->callback([&, map] {
    c.options = command::options_used(*map), c.program = program();
    run = [&] { return run_map(c, terminal); };
  });
}

void define_grid(CLI::App& app, MapCommand& c, Terminal& terminal, Run& run) {
  CLI::App* const grid =
      app.add_subcommand("grid", "the same from a registered cloud as it lies, no drift corrected");
  add_input(*grid, "cloud", c.scans, "clouds in the map frame, or folders of them",
            command::kFileOrFolder)
      ->required();
  add_base_or_none(*grid, c);
  add_fusion(*grid, c);
  add_results(*grid, c, "folder for the results, made if missing")->required();
  add_threads(*grid, c.threads);
  grid->footer("Example:\n  lidar2mesh grid survey.las --road track.crg -o out");
  grid->callback([&, grid] {
    c.options = command::options_used(*grid), c.program = program();
    c.frame = "map", c.correct_drift = false;
    run = [&] { return run_map(c, terminal); };
  });
}

void define_split(CLI::App& app, SplitCommand& c, Terminal& terminal, Run& run) {
  CLI::App* const split = app.add_subcommand(
      "split", "cuts the scans of a map by stretch of the road, for map-tile and merge");
  add_scans(*split, c.map)->required();
  add_base(*split, c.map)->required();
  split->add_option("--tiles", c.tiles, "how many [8]")->check(CLI::Range(1, 1000));
  add_placing(*split, c.map);
  add_fusion(*split, c.map);
  add_output_folder(*split, c.map.output_dir, "folder for the tiles, made if missing")->required();
  split->footer("Example:\n  lidar2mesh split scans --trajectory t.csv --road track.crg -o tiles");
  split->callback([&, split] {
    c.map.options = command::options_used(*split);
    run = [&] { return run_split(c, terminal); };
  });
}

void add_step(CLI::App& app, int& step) {
  app.add_option("--step", step, "1 to 3: drift, 4: heights")->check(CLI::Range(1, 4))->required();
}

void define_map_tile(CLI::App& app, MapTileCommand& c, Terminal& terminal, Run& run) {
  CLI::App* const tile = app.add_subcommand(
      "map-tile", "sums up what the points of one tile say in one step of a map");
  add_input(*tile, "folder", c.folder, "made by split", command::kFolder)->required();
  tile->add_option("--tile", c.tile, "from 1 on")->check(CLI::Range(1, 1000))->required();
  add_step(*tile, c.step);
  add_threads(*tile, c.threads);
  tile->footer("Example:\n  lidar2mesh map-tile tiles --step 1 --tile 3");
  tile->callback([&] { run = [&] { return run_map_tile(c, terminal); }; });
}

void define_merge(CLI::App& app, MergeCommand& c, Terminal& terminal, Run& run) {
  CLI::App* const merge = app.add_subcommand(
      "merge", "joins what all tiles said in one step; after the last the road is made");
  add_input(*merge, "folder", c.folder, "made by split", command::kFolder)->required();
  add_step(*merge, c.step);
  add_results(*merge, c.map, "--step 4: folder for the results, made if missing");
  add_threads(*merge, c.map.threads);
  merge->footer("Example:\n  lidar2mesh merge tiles --step 4 -o out\n\nExit code 3: as 'map'.");
  merge->callback([&, merge] {
    c.map.options = command::options_used(*merge);
    run = [&] { return run_merge(c, terminal); };
  });
}

int main_with(int argc, char** argv) {
  CLI::App app("lidar2mesh: refines the map of a road from LiDAR.", "lidar2mesh");
  app.footer("Built " + about_pcl() + ".");
  app.require_subcommand(1);
  app.get_formatter()->column_width(40);
  Terminal terminal("lidar2mesh");
  Run run;
  InfoCommand info;
  GroundCommand ground;
  RegisterCommand reg;
  SynthCommand synth;
  MapCommand map, grid;
  SplitCommand split;
  MapTileCommand map_tile;
  MergeCommand merge;
  ChangesCommand changes;
  TilesCommand tiles;
  define_info(app, info, terminal, run);
  define_ground(app, ground, terminal, run);
  define_register(app, reg, terminal, run);
  define_map(app, map, terminal, run);
  define_grid(app, grid, terminal, run);
  define_split(app, split, terminal, run);
  define_map_tile(app, map_tile, terminal, run);
  define_merge(app, merge, terminal, run);
  define_changes(app, changes, terminal, run);
  define_tiles(app, tiles, terminal, run);
  define_synth(app, synth, terminal, run);
  return command::run(app, terminal, argc, argv, [&] { return run(); },
                      {"give a part of the points, or one scan at a time", "", about_pcl()});
}

}  // namespace
}  // namespace lidar2mesh

int main(int argc, char** argv) { return lidar2mesh::main_with(argc, argv); }
