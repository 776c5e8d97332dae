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

}  // namespace crgidentify
