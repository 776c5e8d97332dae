// A recorded drive repeated by the simulated car, and how far it comes out elsewhere.
#pragma once

#include <string>
#include <vector>

#include "base/progress.h"
#include "recording/recording.h"
#include "vehicle/driver.h"

namespace vehicle {

struct ReplayOptions {
  double window_s = 2.0;     ///< the car is put back on the recording this often; 0: never
  double settle_s = 0.5;     ///< driven before each window, so that what is not recorded settles
  bool closed_path = false;  ///< the driver steers along the recorded path; else open loop
  /// A push along the car holds speed and place along the path to the recording, beside the
  /// recorded pedals: what the simulated car lacks, in newton. Not with `driver`.
  bool hold_speed = false;
  /// The built-in driver steers, accelerates, brakes and shifts along the recorded path at the
  /// recorded speed; no recorded command is used.
  bool driver = false;
  double fuel_kg = 30.0, tyre_k = 360.0, disc_k = 500.0;  ///< at the begin, where not recorded
  StepOptions step;
  DriverOptions driver_options;
  base::Progress progress;
};

/// How far a channel was from the recording, over all windows. Trivial predictors: `hold`, the
/// channel stays as it was at the window's begin; `trend`, it goes on along the straight line
/// through its last 0.2 s before.
struct ChannelError {
  std::string channel;  ///< of the telemetry; or along_m, lateral_m: the place seen from
                        ///< the recorded one
  std::size_t samples = 0;
  double max = 0.0, rmse = 0.0;
  double hold_max = 0.0, hold_rmse = 0.0;
  double trend_max = 0.0, trend_rmse = 0.0;
};

struct ReplayResult {
  std::vector<std::string> driven_by;  ///< sentences: which channel drives what, what was assumed
  std::size_t windows = 0;
  std::size_t standing = 0;  ///< windows in which the recorded car hardly moved: left out
  std::size_t too_short =
      0;  ///< stretches of the recording shorter than settling and a tenth of a second
  std::vector<std::string> problems;  ///< windows that ended early: one sentence each
  std::vector<ChannelError> errors;
  double hold_mean_n = 0.0, hold_rms_n = 0.0, hold_most_n = 0.0;  ///< of the push, hold_speed only
  double step_swing = 0.0;     ///< StepSwing::largest() of the window where it was largest
  std::string swing_warning;   ///< StepSwing::warning() of that window
  double ledge_most_j = 0.0;   ///< of the window where it was most
  std::string ledge_warning;   ///< of that window, of ledges.h
  recording::Table telemetry;  ///< simulated channels, `hold_n` (0 without hold_speed) and `window`
                               ///< (from 1) at the recorded times
};

/// Drives the recorded commands. Needs the channels x_m, y_m, yaw_rad, vx_mps, throttle_command or
/// throttle, and steer_command_rad or steer_rad unless the driver steers; where a command is not
/// recorded, the measured value drives the car past that actuator. Positions are those of the
/// design centre of mass in the frame of the road. At the begin of a window the recorded place,
/// heading, speeds, yaw rate, wheel and engine speeds and temperatures replace the simulated ones;
/// height, roll, pitch and travel too where
/// all of them were recorded (in the frame of the road), else they stay as they settled. Throws
/// Error when channels are missing. Deterministic.
ReplayResult replay(const Car<double>& car, const Road& road, const recording::Recording& recording,
                    const ReplayOptions& options = {});

/// errors as CSV: channel,samples,max,rmse,hold_max,hold_rmse,trend_max,trend_rmse.
std::string format_errors(const ReplayResult& result);

}  // namespace vehicle
