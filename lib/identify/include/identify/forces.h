// Virtual telemetry: forces, slips and loads of every wheel of a recorded drive, by smoothing the
// simulated car through the log.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "base/progress.h"
#include "recording/channels.h"
#include "recording/recording.h"
#include "recording/table.h"
#include "vehicle/road.h"

namespace identify {

struct ForcesOptions {
  double fuel_kg = 30.0, tyre_k = 360.0, disc_k = 500.0;  ///< at the begin, where not recorded
  double imu_ahead_m = 0.0, imu_yaw_rad = 0.0;            ///< as recording::Mapping says
  /// How far the car's numbers may be off, as vehicle::ParameterInfo has it: two standard
  /// deviations. 0: the car is exactly the stated one.
  std::array<double, vehicle::kParameterCount> prior{};
  /// How far the tyre files' rolling resistance, and what load and speed do to their rolling radii,
  /// may be off: a share, one standard deviation. Slip 0 is known as well as they are.
  double rolling_sd = 0.0;
  double step_s = 0.002;         ///< of the derivatives, at most; the car has finer steps itself
  double least_mps = 5.0;        ///< slower rows are left out: slips are regularised there
  int noise_rounds = 8;          ///< of estimating noises from the log; 0: as a first look says
  double noise_sample_s = 32.0;  ///< of the log that these rounds look at
  unsigned threads = 0;          ///< 0: all cores; the result is the same
  base::Progress progress;
};

/// A number with its standard deviation, row by row; NaN where the row was left out.
struct Estimated {
  std::vector<double> value, sd;
};

struct WheelForces {
  Estimated fx_n, fy_n, fz_n;  ///< along the wheel's heading, to its left, along the road's normal
  Estimated kappa, alpha_rad;  ///< slips that the tyre feels, in the signs of a tyre file
  Estimated camber_rad;        ///< against the road, positive to the right
  Estimated power_w;           ///< that sliding turns into heat, positive
  std::vector<double> vx_mps, tyre_k;
};

/// What the log and the car said about one channel.
struct ChannelUse {
  std::string channel;
  std::size_t rows = 0;
  double noise = 0.0;  ///< standard deviation, estimated from the log
};

/// A part of the car whose difference from the vehicle file was followed, as shares: its
/// mean, and the standard deviation about it that it was found to need.
struct PartUse {
  std::string part;
  double mean = 0.0, freedom = 0.0;
};

/// A number of the vehicle file that is taken as stated, and how far it may be off: a share, one
/// standard deviation. It counts in those of all rows. A number that is 0 stays 0.
struct StatedUse {
  std::string name;
  double sd = 0.0;
};

struct Forces {
  std::vector<double> time_s, u_m, v_m;
  std::array<WheelForces, vehicle::kWheels> wheel;
  std::array<Estimated, 2> axle_fx_n, axle_fy_n, axle_fz_n;  ///< sums over the axle's wheels
  Estimated vx_mps, vy_mps, yaw_rate_radps, steer_rad, sideslip_rad;
  std::vector<ChannelUse> channels;
  std::vector<PartUse> parts;
  std::vector<StatedUse> stated;
  std::vector<std::string> remarks;
  std::vector<std::string> doubts;  ///< why these forces must not be used; empty: none was found
  std::size_t rows = 0;             ///< that have forces
  std::size_t slow = 0;             ///< left out: standing or slower than least_mps
  std::size_t unsettled = 0;        ///< left out: begin of a stretch
  std::size_t lost = 0;             ///< left out: the simulated car could not follow
  std::size_t off_road = 0;         ///< among `rows`: a wheel beside the road's grid or over a hole
  double dry_kg = 0.0;              ///< mass without fuel, of the car's files
  double fuel_kg = 0.0;             ///< at the begin: recorded, else as ForcesOptions says
  bool fuel_recorded = false;
  std::size_t wild = 0, measurements = 0;  ///< numbers further than four deviations from expected
};

/// One kind of number as a column: "fx_" + place + "_n", its deviation "fx_" + place + "_sd_n".
template <class Member>
struct ForcesColumn {
  const char *name, *ending, *unit;
  Member of;
};
inline constexpr ForcesColumn<Estimated WheelForces::*> kWheelColumns[] = {
    {"fx_", "_n", "N", &WheelForces::fx_n},
    {"fy_", "_n", "N", &WheelForces::fy_n},
    {"fz_", "_n", "N", &WheelForces::fz_n},
    {"kappa_", "", "1", &WheelForces::kappa},
    {"alpha_", "_rad", "rad", &WheelForces::alpha_rad},
    {"camber_", "_rad", "rad", &WheelForces::camber_rad},
    {"power_", "_w", "W", &WheelForces::power_w}};
inline constexpr ForcesColumn<std::array<Estimated, 2> Forces::*> kAxleColumns[] = {
    {"fx_", "_n", "N", &Forces::axle_fx_n},
    {"fy_", "_n", "N", &Forces::axle_fy_n},
    {"fz_", "_n", "N", &Forces::axle_fz_n}};
inline constexpr ForcesColumn<Estimated Forces::*> kCarColumns[] = {
    {"vx", "_mps", "m/s", &Forces::vx_mps},
    {"vy", "_mps", "m/s", &Forces::vy_mps},
    {"yaw_rate", "_radps", "rad/s", &Forces::yaw_rate_radps},
    {"sideslip", "_rad", "rad", &Forces::sideslip_rad},
    {"steer", "_rad", "rad", &Forces::steer_rad}};
/// Needs x_m, y_m, yaw_rad, vx_mps, steer_rad and throttle (or their commands), positions in the
/// road's frame; everything else that was recorded is used. Noises of channels, and how far tyres,
/// brakes and engine may differ from the car's, are estimated from the log by expectation
/// maximisation. Throws base::Error where channels are missing or no stretch can be followed. The
/// same inputs give the same bytes for any number of threads.
Forces estimate_forces(const vehicle::Car<double>& car, const vehicle::Road& road,
                       const recording::Recording& recording, const ForcesOptions& options = {});

/// Rows that have forces: time_s, u_m, v_m, per wheel fx, fy, fz, kappa, alpha, camber, each with
/// its standard deviation (..._sd_...), vx and tyre temperature of the wheel; per axle fx, fy, fz;
/// speeds, sideslip and steering of the car.
recording::Table forces_table(const Forces& forces);

/// Columns, and what their numbers rest on: what was measured, what is the vehicle file's word and
/// was not observed.
std::vector<std::pair<std::string, std::string>> forces_basis(const Forces& forces);

}  // namespace identify
