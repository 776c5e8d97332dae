// Runs any of the tools as a shell or a person at a terminal would.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace support {

struct ToolRun {
  int code = -1;  ///< exit code; 128 + signal when killed by one
  std::string out, err;
  double seconds_after_signal = 0.0;  ///< from the signal to the end
  double processor_s = 0.0;
  std::size_t most_resident_bytes = 0;
};

struct ToolOptions {
  std::string in = "/dev/null", out = "";  ///< files; empty: `out` is read back
  double signal_after_s = 0.0;             ///< 0: none
  int signal = 15;
  std::string signal_once_exists = "";  ///< signal_after_s counts from when this file exists
  std::size_t most_address_bytes = 0;   ///< that it may have; 0, or under a sanitizer: no limit
  unsigned most_clock_s = 0;            ///< it is ended by SIGALRM then; 0: never
};

/// With standard output and error in pipes or files, never a terminal.
ToolRun run_tool(const std::string& program, const std::vector<std::string>& arguments,
                 const ToolOptions& options = {});

/// On a terminal of its own. Once what it shows matches `until` (a regular expression) it gets
/// Ctrl-C; err is all that was shown.
ToolRun run_on_terminal(const std::string& program, const std::vector<std::string>& arguments,
                        const std::string& until, const std::vector<std::string>& environment = {});

struct Tool {
  std::string name, path;
};
std::vector<Tool> all_tools();

/// The commands of a tool, found by reading --help: "info", "trials make".
std::vector<std::vector<std::string>> commands_of(const Tool& tool);

}  // namespace support
