// One struct and one function per subcommand; the functions return the exit code.
#pragma once

#include <cstdint>
#include <optional>
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
  std::string axle;           ///< front or rear, of folders that `forces` wrote
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

struct ReduceCommand {
  std::string vehicle_path, setup_path, track_path, out_path;
  std::vector<std::string> settings;  ///< name=value
  double fuel_kg = 30.0;
  std::vector<double> speed_mps{15.0, 0.0};  ///< lowest and highest; 0: the car's own
  std::size_t speeds = 5, slips = 20;
  std::vector<double> gravities{0.6, 1.0, 1.5};
  std::vector<double> most_share{0.02, 0.015};  ///< of the lap and of the limit
  unsigned threads = 0;
};
int reduce(const ReduceCommand& command, Terminal& terminal);

/// Of identify::kAssumedFuel_kg.
inline constexpr const char* kFuelAssumed = "assumption: neither the log nor --fuel-kg states it";

struct ForcesCommand {
  std::vector<std::string> recording_paths;
  std::string vehicle_path, setup_path, track_path, friction_path, mapping_path, out_path;
  std::vector<std::string> settings;  ///< name=value
  std::optional<double> fuel_kg;      ///< none: identify::kAssumedFuel_kg
  double tyre_k = 360.0, disc_k = 500.0, step_s = 2e-3;
  int noise_rounds = 8;
  unsigned threads = 0;
};
int forces(const ForcesCommand& command, Terminal& terminal);

/// Of the commands that fit parts of a car to one drive.
struct DriveCommand {
  std::string part;  ///< of identify::kMeasuredParts
  std::string recording_path, vehicle_path, setup_path, track_path, mapping_path, out_path;
  std::vector<std::string> settings;    ///< name=value
  std::string accelerations = "body";   ///< body or road
  std::optional<double> fuel_kg;        ///< none: kAssumedFuel_kg
  std::string pad_map_path;             ///< brakes only
  std::string plots_path;               ///< engine and brakes only
  std::vector<std::string> engine_off;  ///< BEGIN,END in seconds of the log; aero only
};
int drive_part(const DriveCommand& command, Terminal& terminal);

}  // namespace crgidentify
