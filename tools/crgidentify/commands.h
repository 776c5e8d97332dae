// One struct and one function per subcommand; the functions return the exit code.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "command/exit_code.h"
#include "command/terminal.h"

namespace crgidentify {

using command::kOk, command::Terminal;

struct TyreCommand {
  std::vector<std::string> bench_paths;
  std::string reference_path, out_path, plots_path;
  std::string alpha = "tan";  ///< tan or angle
  int starts = 8;
  std::uint64_t seed = 1;
  unsigned threads = 0;
};
int tyre(const TyreCommand& command, Terminal& terminal);

struct ActuatorCommand {
  std::string recording_path, mapping_path, out_path, plots_path;
  std::string part = "steering";  ///< steering, throttle or brake
  std::string input, movement;    ///< channels; empty: those of the part
  std::string order = "auto", hold = "auto";
  unsigned threads = 0;
};
int actuator(const ActuatorCommand& command, Terminal& terminal);

}  // namespace crgidentify
