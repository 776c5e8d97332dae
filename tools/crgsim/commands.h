// One struct and one function per subcommand; the functions return the exit code.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/growing_file.h"
#include "command/exit_code.h"
#include "command/terminal.h"
#include "sim/run_unit.h"

namespace crgsim {

using command::kOk, command::Terminal;

struct InfoCommand {
  std::string unit_path;
};
int info(const InfoCommand& command, Terminal& terminal);

struct RunCommand {
  std::string unit_path, road_path, inputs_path, out_path;
  std::vector<std::string> starts, record, opponents;
  std::size_t every = 1;
  double start_s = kFromTheUnit, stop_s = kFromTheUnit, step_s = kFromTheUnit;
  static constexpr double kFromTheUnit = -1e300;
  sim::UnitLimits limits;
};
int run(const RunCommand& command, Terminal& terminal);

struct ServeCommand {
  std::string unit_path, socket_path, devices_path, road_path, inputs_path, sights_path, out_path;
  std::uint16_t udp_port = 0;
  std::vector<std::string> commands, measurements, recorded, starts, safe, opponents;
  double safe_after_s = 0.2, stop_s = 60.0, step_s = 0.001, speed_up = 1.0, patience_s = 30.0;
  unsigned every = 10, domain = 0;
  bool lockstep = false, dds = false;
  std::string topic_prefix;           ///< of a car in a race, as the next one
  std::optional<std::uint64_t> seed;  ///< instead of that of the devices' file
  sim::UnitLimits limits;
};
int serve(const ServeCommand& command, Terminal& terminal);

struct RaceCommand {
  std::string race_path, out_path, socket_path;
  std::uint16_t udp_port = 0;
  double stop_s = 60.0, step_s = 0.001, speed_up = 1.0;
  unsigned domain = 0;
  bool lockstep = false, dds = false, sights = false;
  sim::UnitLimits limits;
};
int race(const RaceCommand& command, Terminal& terminal);

struct RaceCar {
  std::string name;
  ServeCommand serve;
};

/// The cars of a race's file, each as options of serve would have said it, with its own connection
/// and what all share. Throws Error with path:line, and UsageError on connections.
std::vector<RaceCar> read_race(const RaceCommand& command);

/// Throws UsageError unless one connection is named.
template <class Command>
void want_one_connection(const Command& command) {
  if ((command.socket_path.empty() ? 0 : 1) + (command.udp_port == 0 ? 0 : 1) +
          (command.dds ? 1 : 0) !=
      1)
    throw command::UsageError("one of --socket PATH, --udp PORT and --dds is wanted");
}

/// What was refused a unit by its sandbox, as a remark; empty: nothing.
std::string refused_remark(const std::string& refused);

/// NAME=VALUE taken apart. Throws UsageError where it is none.
std::pair<std::string, std::string> assignment(const std::string& option, const std::string& text);

/// Inputs over time from a CSV file; none where there is no path. Throws Error with path:line.
sim::UnitInputs read_inputs(const std::string& path);

/// Rows as CSV into a file, as they come, after the names of the columns: numbers that read back as
/// the same bits, names with commas in quotes. `file` has to stay.
sim::KeepRow rows_into(base::GrowingFile& file);

/// Lines into a file as they come. `file` has to stay.
std::function<void(std::string_view)> lines_into(base::GrowingFile& file);

/// Beside a record, what was said besides numbers: "out/drive.csv" gives "out/drive.remarks.jsonl".
std::string remarks_path(const std::string& record_path);

/// Says where rows of a run lie that was killed.
void say_killed(const base::GrowingFile& file, Terminal& terminal);

}  // namespace crgsim
