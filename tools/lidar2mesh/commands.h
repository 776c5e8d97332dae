// The subcommands, one options struct and one function each. main.cpp turns arguments into the
// structs; the functions load, call the library, save and print. They throw on failure; what they
// return is the exit code.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cloud/map_inputs.h"
#include "cloud/map_scans.h"
#include "cloud/refine.h"
#include "command/exit_code.h"
#include "command/terminal.h"
#include "provenance.h"

namespace lidar2mesh {

using command::kNotValid, command::kOk, command::one_line, command::Terminal;

using cloud::metres_per_unit;

/// Throws UsageError where these are no numbers of --outliers.
void want_outliers(const std::vector<double>& outliers);

struct InfoCommand {
  std::string cloud, unit;
};
int run_info(const InfoCommand& command, Terminal& terminal);

struct GroundCommand {
  std::string cloud, output, unit, method = "own";
  double cell_m = 1.0, height_m = 0.5;
  std::optional<double> window_m, slope;  ///< [as the method does]
  bool doubles = false;
  Options options;
};
int run_ground(const GroundCommand& command, Terminal& terminal);

struct RegisterCommand {
  std::string target, source, output, unit, method = "own";
  double voxel_m = 0.25, reach_m = 2.0;
  std::vector<double> outliers;  ///< neighbours, deviations
  bool doubles = false, coarse = false, robust = false;
  std::uint32_t seed = 1;
  unsigned threads = 0;
  Options options;
};
int run_register(const RegisterCommand& command, Terminal& terminal);

struct ChangesCommand {
  std::string before, after, output_dir, unit;
  double cell_m = 0.0, min_change_m = 0.01, level_m = 30.0, octree_m = 0.0;
};
int run_changes(const ChangesCommand& command, Terminal& terminal);

struct TilesCommand {
  std::vector<std::string> clouds;
  std::string trajectory, output_dir, unit;
  std::vector<double> extrinsic;  ///< x, y, z (m), roll, pitch, yaw (deg)
  unsigned threads = 0;
  Options options;
};
int run_tiles(const TilesCommand& command, Terminal& terminal);

struct SynthCommand {
  std::string road, output_dir;
  int laps = 2, beams = 64, azimuths = 1024, cars = 2;
  double u_begin_m = 0.0, u_end_m = 0.0, speed_mps = 20.0, noise_m = 0.005, drift_m = 0.05,
         drift_rad = 0.002, grass_m = 0.0, scenery_m = 0.0;
  std::vector<double> v_m;
  std::uint64_t seed = 1;
  unsigned threads = 0;
  Options options;
};
int run_synth(const SynthCommand& command, Terminal& terminal);

using MapCommand = cloud::RefineRequest;
int run_map(const MapCommand& command, Terminal& terminal);
/// What was made, in a few lines. Throws NotValid where the road must not be used.
int show_map(const MapCommand& command, const cloud::Refined& refined, Terminal& terminal);

/// Of `map`: output_dir is the folder of the tiles, and what only the outputs want stays as it is.
struct SplitCommand {
  MapCommand map;
  int tiles = 8;
};
int run_split(const SplitCommand& command, Terminal& terminal);

struct MapTileCommand {
  std::string folder;
  int tile = 1, step = 1;
  unsigned threads = 0;
};
int run_map_tile(const MapTileCommand& command, Terminal& terminal);

/// Of `map` the outputs alone; output_dir for the last step.
struct MergeCommand {
  std::string folder;
  int step = 1;
  MapCommand map;
};
int run_merge(const MergeCommand& command, Terminal& terminal);

}  // namespace lidar2mesh
