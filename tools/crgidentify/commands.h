// One struct and one function per subcommand; the functions return the exit code.
#pragma once

#include <fmt/format.h>

#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "command/exit_code.h"
#include "command/terminal.h"
#include "identify/forces.h"
#include "identify/measure.h"
#include "identify/reduce.h"
#include "identify/tyre_fit.h"

namespace crgidentify {

using command::kOk, command::Terminal;

struct TyreCommand {
  std::vector<std::string> bench_paths;
  std::string reference_path, out_path, plots_path;
  std::string alpha = "tan";  ///< tan or angle
  std::string axle;           ///< front or rear, of folders that `forces` wrote
  identify::TyreFitOptions options;
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

struct ReduceCommand {
  std::string vehicle_path, setup_path, track_path, out_path;
  std::vector<std::string> settings;            ///< name=value
  std::vector<double> speed_mps{15.0, 0.0};     ///< lowest and highest; 0: the car's own
  std::vector<double> most_share{0.02, 0.015};  ///< of the lap and of the limit
  identify::ReduceOptions options;
};
int reduce(const ReduceCommand& command, Terminal& terminal);

/// Of identify::kAssumedFuel_kg.
inline constexpr const char* kFuelAssumed = "assumption: neither the log nor --fuel-kg states it";

struct ForcesCommand {
  std::vector<std::string> recording_paths;
  std::string vehicle_path, setup_path, track_path, friction_path, mapping_path, out_path;
  std::vector<std::string> settings;  ///< name=value
  std::optional<double> fuel_kg;      ///< none: identify::kAssumedFuel_kg
  identify::ForcesOptions options;
};
int forces(const ForcesCommand& command, Terminal& terminal);

/// Of the commands that fit parts of a car to one drive.
struct DriveCommand {
  std::string part;  ///< of identify::kMeasuredParts
  identify::MeasureRequest request;
  std::string out_path;
  std::string accelerations = "body";   ///< body or road
  std::string pad_map_path;             ///< brakes only
  std::string plots_path;               ///< engine and brakes only
  std::vector<std::string> engine_off;  ///< BEGIN,END in seconds of the log; aero only
};
int drive_part(const DriveCommand& command, Terminal& terminal);

/// "; 12 rows too slow", of those that there are.
inline std::string rows_said(
    std::initializer_list<std::pair<std::size_t, const char*>> rows_and_why) {
  std::string out;
  for (const auto& [rows, why] : rows_and_why)
    if (rows > 0) out += fmt::format("; {} {}", rows, why);
  return out;
}

}  // namespace crgidentify
