// One struct and one function per subcommand; the functions return the exit code.
#pragma once

#include <string>
#include <vector>

namespace crgexplain {

struct MapCommand {
  std::string log_path, out_path;
};
int map(const MapCommand& command);

struct RunCommand {
  std::string track_path, vehicle_path, mapping_path, out_path;
  std::vector<std::string> recording_paths;
  std::vector<int> hold_out;
  unsigned threads = 0;
  std::size_t nulls = 1000;
  bool skip_simulation = false;
};
int run(const RunCommand& command);

struct TrialsCommand {
  std::string what;       ///< make, run or score
  std::string folder, generator;
  int count = 64;
  long long seed = 1;
  unsigned threads = 0;
};
int trials(const TrialsCommand& command);

}  // namespace crgexplain
