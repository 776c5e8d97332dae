// One struct and one function per subcommand; the functions return the exit code.
#pragma once

#include <string>
#include <vector>

#include "command/exit_code.h"
#include "command/terminal.h"

namespace crgsim {

using command::kOk, command::Terminal;

struct InfoCommand {
  std::string unit_path;
};
int info(const InfoCommand& command, Terminal& terminal);

struct RunCommand {
  std::string unit_path, inputs_path, out_path;
  std::vector<std::string> starts, record;
  double start_s = kFromTheUnit, stop_s = kFromTheUnit, step_s = kFromTheUnit;
  static constexpr double kFromTheUnit = -1e300;
};
int run(const RunCommand& command, Terminal& terminal);

}  // namespace crgsim
