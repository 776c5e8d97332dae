// One struct and one function per subcommand; the functions return the exit code.
#pragma once

#include <string>
#include <vector>

#include "command/exit_code.h"
#include "command/terminal.h"
#include "explain/explain.h"
#include "explain/simulate.h"

namespace crgexplain {

using command::kOk, command::one_line, command::shell_word, command::Terminal;

struct MapCommand {
  std::string log_path, out_path;
  bool list = false;
};
int map(const MapCommand& command, Terminal& terminal);

struct RunCommand {
  std::string track_path, friction_path, vehicle_path, mapping_path, out_path;
  std::vector<std::string> recording_paths;
  std::vector<int> hold_out;
  unsigned threads = 0;
  std::size_t nulls = 1000;
  double fuel_kg = 0.0;
  bool skip_simulation = false;
};
int run(const RunCommand& command, Terminal& terminal);

struct SummaryCommand {
  RunCommand inputs;  ///< out_path is the summary's file
};
int summary(const SummaryCommand& command, Terminal& terminal);

struct FleetCommand {
  std::vector<std::string> summary_paths;
  std::string out_path;
  unsigned threads = 0;
};
int fleet(const FleetCommand& command, Terminal& terminal);

}  // namespace crgexplain
