// One struct and one function per subcommand; the functions return the exit code.
#pragma once

#include <string>
#include <vector>

#include "command/exit_code.h"
#include "command/terminal.h"
#include "explain/explain_files.h"

namespace crgexplain {

using command::kOk, command::one_line, command::shell_word, command::Terminal;

struct MapCommand {
  std::string log_path, out_path;
  bool list = false;
};
int map(const MapCommand& command, Terminal& terminal);

struct RoadCommand {
  std::string log_path, mapping_path, out_path;
};
/// A flat road under a drive; where the log has no places, also the log with them beside it.
int flat_road(const RoadCommand& command, Terminal& terminal);

using RunCommand = explain::ExplainRequest;
int run(const RunCommand& command, Terminal& terminal);

/// Verdict, findings and the commands that go on from here.
void print_result(const RunCommand& command, const explain::ExplainedFiles& result,
                  Terminal& terminal);

/// out_path is the summary's file.
int summary(const RunCommand& command, Terminal& terminal);

struct FleetCommand {
  std::vector<std::string> summary_paths;
  std::string out_path;
  unsigned threads = 0;
};
int fleet(const FleetCommand& command, Terminal& terminal);

}  // namespace crgexplain
