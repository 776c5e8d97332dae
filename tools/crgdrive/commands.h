// The subcommands, one options struct and one function each. main.cpp turns arguments into the
// structs; the functions load, call the library, save. They throw on failure; what they return is
// the exit code.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "command/exit_code.h"
#include "command/terminal.h"

namespace crgdrive {

using command::kOk, command::Terminal, command::UsageError;

struct TyreCommand {
  std::string tyre_path;
  std::string points_path, out_path;  ///< both or none
  std::string plots_path;             ///< page of the curves; empty: none
  std::string alpha = "tan";          ///< tan or angle
  bool mirrored = false;
};
int tyre(const TyreCommand& command, Terminal& terminal);

int parameters(Terminal& terminal);

/// What every command that simulates a car takes.
struct CarOptions {
  std::string vehicle_path;
  std::string setup_path;             ///< a setup sheet after the vehicle's own
  std::vector<std::string> settings;  ///< name=value
  std::string contact;                ///< empty: as in the vehicle file
  std::string integrator = "semi-implicit";
  double step_s = 0.001;
  bool stop_off_road = false;
};

/// How a run is watched.
struct LiveOptions {
  double speed_up = 0.0;  ///< 1: real time; 0: as fast as it goes
  std::string udp;        ///< host:port, empty: nowhere
};

struct LapCommand {
  CarOptions car;
  LiveOptions live;
  std::string track_path, friction_path, devices_path;
  std::vector<std::string> out_paths;  ///< of the car and of a second one
  std::vector<std::string> opponents;  ///< logs of other cars, LOG[@2s], or a car, VEHICLE[@15m]
  double opponent_ahead_s = 1.0;       ///< of the first log that says none; of the k-th k times
  std::string second_path, second_out_path;  ///< another simulated car; empty: none
  double second_ahead_m = 15.0;
  double second_grip_usage = 0.75;
  int laps = 1;
  bool standing = false;
  double tyre_k = 360.0, disc_k = 500.0, fuel_kg = 30.0;
  std::vector<double> grip_usage;  ///< of the driver, and of the second car's; empty: he finds it
  double begin_mps = 0.0;          ///< 0: as fast as the engine holds
  std::optional<double> margin_m;  ///< nothing: 2, and more where that is too near
  double rate_hz = 100.0;
};
int lap(const LapCommand& command, Terminal& terminal);

struct ReplayCommand {
  CarOptions car;
  std::string track_path, friction_path, recording_path, mapping_path, out_path;
  double window_s = 2.0;
  bool closed_path = false, hold_speed = false, driver = false;
  double tyre_k = 360.0, disc_k = 500.0, fuel_kg = 30.0;
};
int replay(const ReplayCommand& command, Terminal& terminal);

struct ReportCommand {
  std::string track_path, mapping_path, out_path;
  std::vector<std::string> telemetry;  ///< one or two files; the mapping is the first one's
};
int report(const ReportCommand& command, Terminal& terminal);

struct ManoeuvreCommand {
  CarOptions car;
  LiveOptions live;
  std::string kind, out_path, devices_path;
  double speed_mps = 30.0, duration_s = 6.0, steer_rad = 0.03, frequency_hz = 0.5;
  double pressure_pa = 3e6, height_m = 0.03, low_grip = 0.4, fuel_kg = 30.0;
  double rate_hz = 1000.0;
};
int manoeuvre(const ManoeuvreCommand& command, Terminal& terminal);

struct TimingCommand {
  CarOptions car;
  std::string track_path;
  double seconds = 30.0;
};
int timing(const TimingCommand& command, Terminal& terminal);

struct PolesCommand {
  CarOptions car;
  std::vector<double> speeds_mps{1, 2, 5, 10, 20, 40, 60, 80};
  std::vector<double> steps_s{0.001, 0.0012};
};
int poles(const PolesCommand& command, Terminal& terminal);

struct FmuCommand {
  CarOptions car;
  std::string track_path, friction_path, out_path;
  std::string version = "2";
};
int fmu(const FmuCommand& command, Terminal& terminal);

struct NewCommand {
  std::string sheet_path, out_path;  ///< both, or an example is asked for
  bool example = false;
};
int new_car(const NewCommand& command, Terminal& terminal);

}  // namespace crgdrive
