// A recording as smooth signals on one clock, placed on the road.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "crg/surface.h"
#include "explain/mapping.h"
#include "recording/table.h"

namespace explain {

/// What the relations and the car model need; fronts and rears are means of left and right.
enum Channel : std::size_t {
  kX,
  kY,
  kYaw,
  kVx,
  kVy,
  kYawRate,
  kAx,
  kAy,
  kAz,
  kSteer,
  kThrottle,
  kBrakeFront,
  kBrakeRear,
  kBrakeFrontApart,
  kBrakeRearApart,  ///< left minus right, where more than noise lets the wheels differ
  kWheelFront,
  kWheelRear,            ///< rad/s, or m/s with the logger's own radius (Signals::wheels_in_mps)
  kWheelRearDifference,  ///< left minus right, same unit
  kEngine,
  kGear,
  kFuel,
  kLoadFront,
  kLoadRear,
  kSteerCommand,
  kThrottleCommand,
  kBrakeCommand,  ///< where what came of them is logged too
  kChannelCount
};

/// Columns that come late together: of one device with a clock of its own.
struct LateColumns {
  std::vector<std::string> columns;
  double delay_s = 0.0;  ///< negative: early
};

/// Signals every kStep_s, from a local quadratic fit, so that delays and filters commute with it.
struct Signals {
  static constexpr double kStep_s = 0.05;
  static constexpr double kRolls_mps = 6.0;  ///< its wheels turn as it goes
  std::string name;
  std::size_t n = 0;
  std::array<std::vector<double>, kChannelCount> x, dx;  ///< value and time derivative; NaN: none
  std::array<bool, kChannelCount> present{};
  std::array<bool, kChannelCount> commanded{};    ///< a command, not a measurement
  std::array<std::string, kChannelCount> column;  ///< the log's own name
  std::array<std::vector<double>, kChannelCount>
      noise;  ///< of yaw rate and accelerations: a draw of what their noise is in x
  bool wheels_in_mps = false;
  double imu_yaw_rad = 0.0, imu_ahead_m = 0.0;  ///< as the mapping states
  std::vector<double> u_m, v_m, grade, bank,
      curvature_v;  ///< road under the car: rise along the car,
                    ///< rise to its left, second derivative along it
  /// Root mean square, over a second, of what waves of the road press with that are smoothed away
  /// there, as a share of gravity. Empty: not read.
  std::vector<double> pressed_swing;
  std::vector<double> heading_rad,
      line_curvature_1pm;    ///< of the reference line; left turns positive
  std::vector<double> grip;  ///< factor of the road's friction map under the car; 1 without one
  std::vector<int> lap;      ///< 0, 1, ...: counted at the line
  std::vector<bool> whole;   ///< per lap: begins and ends at the line
  double rounds = 0.0;       ///< driven in all, wherever it began; of a closed road
  double sample_hz = 0.0;
  double length_m = 0.0;  ///< of the road; laps wrap if closed
  bool closed = false;
  LateColumns late;     ///< what was moved in time before it was used
  bool broken = false;  ///< a column was left out that the mapping or the log has to be mended for
  std::vector<std::string> remarks;
};

/// Reads, maps, smooths, projects. Throws vehicle::Error naming the file when there is no position
/// or speed, the clock goes back, the log is shorter than 10 s, or the car is not on this road
/// (then with the rotation and shift that would bring it there, if one is found).
Signals make_signals(const recording::Table& table, const Mapping& mapping,
                     const crg::Surface& surface, const std::string& name);

/// Mean speed over that of an axle's wheels as they are logged, where the car rolls; 0: not known.
double speed_over_wheels(const Signals& log, Channel wheels);
/// The axle whose wheels' speed the logged one is within 0.2 %: their radius and filter are in it.
std::optional<Channel> wheels_of_speed(const Signals& log);

}  // namespace explain
