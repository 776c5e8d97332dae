// Whole laps by the built-in driver.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "base/progress.h"
#include "vehicle/driver.h"
#include "vehicle/opponent.h"
#include "vehicle/sensors.h"

namespace vehicle {

/// A step of a lap.
struct LapStep {
  double time_s = 0.0;  ///< at its begin
  const State<double>&before, &after;
  const Detail<double>& detail;
  const RacingLine& line;
  std::size_t station = 0;  ///< of the line, where the driver is
};

struct LapOptions {
  int laps = 1;
  bool standing = false;  ///< from standstill; otherwise at the profile's speed
  double ahead_m = 0.0;   ///< begins this much further along its line than a car does otherwise
  double tyre_k = 360.0;  ///< of the tyres at the start
  double disc_k = 500.0;  ///< of the brake discs at the start
  double fuel_kg = 30.0;
  double longest_s = 600.0;       ///< per lap, before it counts as not finished
  std::size_t record_every = 10;  ///< steps per row of telemetry; 0: none
  StepOptions step;
  const DeviceFile* devices = nullptr;  ///< telemetry as these measure it; nullptr: ideal
  std::function<void(const recording::Table&)> on_row;  ///< called after each row of telemetry
  std::function<void(const LapStep&)> on_step;          ///< called after each step
  base::Progress progress;
  std::vector<Opponent> opponents;  ///< cars whose wakes act; telemetry gets wake_x_m, wake_y_m
  DriverOptions driver;
  RacingLineOptions line;
  SpeedOptions speed;  ///< temperatures and fuel are taken from the run
};

struct LapResult {
  bool complete = false;             ///< every lap was finished
  std::string problem;               ///< one sentence if not
  std::vector<double> lap_s;         ///< one per finished lap, interpolated between steps
  std::string limit;                 ///< which one the car met where it left its line; empty: none
  double furthest_off_line_m = 0.0;  ///< of the car's centre from the racing line
  double least_edge_m = 0.0;         ///< smallest distance of a wheel to the edge of the v range
  std::size_t steps_off_road = 0;    ///< steps with a wheel beside the grid or over a hole
  double top_mps = 0.0;
  double step_swing = 0.0;    ///< StepSwing::largest()
  std::string swing_warning;  ///< StepSwing::warning()
  std::string ledge_warning;  ///< of ledges.h
  std::size_t steps = 0;
  double surge_s = 0.0;  ///< compressor below the surge line of its map (compressor_surge_kgps)
  /// Least distance of its centre to that of another car of the run; cars do not touch.
  double nearest_m = std::numeric_limits<double>::infinity();
  Powers<double> energy_j;       ///< what each power added up to, over all laps
  double energy_change_j = 0.0;  ///< change of the car's energy over the same steps
  recording::Table telemetry;
};

/// Drives laps of a road; an open road is driven once, with all wheels on it from its begin to its
/// end. The same arguments give the same result to the bit. Throws Error when no line can be
/// planned, and when several laps of an open road are asked for.
LapResult drive_laps(const Car<double>& car, const Road& road, const LapOptions& options = {});

struct TunedLaps {
  LapResult result;
  double grip_usage = 0.0;  ///< SpeedOptions::grip_usage of it
  double margin_m = 0.0;    ///< RacingLineOptions::margin_m of it
};

constexpr double kLeastGripUsage = 0.45;
enum class Margin : std::uint8_t { as_given, wider_where_wanted };
/// Laps by a driver who uses 0.1 less of the grip each time, at least kLeastGripUsage, as long as
/// the car leaves its line; then, where he may, the same with twice the margin, or what the road
/// has. Where none of them keeps it, the first. Throws Error as drive_laps.
TunedLaps drive_laps_tuned(const Car<double>& car, const Road& road, LapOptions options = {},
                           Margin margin = Margin::wider_where_wanted);

/// A car of a run with others.
struct Entrant {
  const Car<double>* car = nullptr;
  LapOptions options;
};

/// Drives several cars at once, each by its own driver, step by step together: before each step
/// each sees where all the others are, whose wakes act like those of opponents. A car that has
/// driven its laps, or whose run ended, leaves the road. Cars do not touch one another and their
/// drivers do not see one another. One result per car; the same arguments give the same results to
/// the bit. Throws Error as drive_laps, and where the cars' steps differ.
std::vector<LapResult> drive_together(std::span<const Entrant> cars, const Road& road);

}  // namespace vehicle
