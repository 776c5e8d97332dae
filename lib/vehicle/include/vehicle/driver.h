// The built-in driver: follows a racing line at its speed profile.
#pragma once

#include <cstddef>

#include "vehicle/racing_line.h"
#include "vehicle/step.h"

namespace vehicle {

struct DriverOptions {
  double preview_s = 0.3;       ///< time ahead of the point he steers at
  double preview_m = 5.0;       ///< and the distance that adds to it
  double drift_gain = 0.6;      ///< against staying beside the line, over the preview cubed
  double yaw_damping = 1.0;     ///< steering against a yaw rate that the path does not ask for
  double tail_damping = 1.0;    ///< and on top where the car turns further than the path asks
  double speed_gain_1ps = 1.2;  ///< acceleration asked per speed error
  double slip_drive = 0.09;     ///< wheel slip above which he lifts, at a grip of 1 or more
  double slip_brake = 0.09;     ///< wheel slip above which he releases a wheel's brake, or,
                                ///< where grip is below 1, the clutch
  double full_brake_pa = 8e6;
  double step_s = 0.001;  ///< how often he is asked
};

/// Closes path and speed; a plain value, so that copying it with the Simulation restarts both.
struct Driver {
  DriverOptions options;
  double s_m = 0.0;  ///< his place along the line
  std::size_t station = 0;
  double drift_m2 = 0.0;  ///< distance left of the line, summed over the way
  double throttle = 0.0;
  double missing_nm = 0.0;  ///< full turbocharged engine: torque asked on top while boost is built
  int gear = 1;
};

/// What he does now. `detail` is that of the last step (all zero before the first). Steers with
/// pure pursuit of a point ahead on the line plus the understeer the car has; asks the acceleration
/// of the speed profile, with engine, drag and brakes known; lifts when wheels slip.
Controls<double> drive(Driver& driver, const RacingLine& line, const Car<double>& car,
                       const State<double>& state, const Detail<double>& detail);

/// The gear for a speed, of those the car has: the highest wheel torque below the limiter, not
/// shifting back for less than a tenth of the engine's range.
int choose_gear(const Car<double>& car, double vx_mps, int gear_now);

}  // namespace vehicle
