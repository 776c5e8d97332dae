// What an actuator is, found from its recorded command and movement.
#pragma once

#include <vector>

namespace vehicle {

/// output = gain (1 + lead s) / (1 + 2 damping lag s + lag^2 s^2) e^(-dead time s) command: at a
/// step h the ARX model y[k] = a1 y[k-1] + a2 y[k-2] + b0 u[k-d] + b1 u[k-d-1] with d = dead time /
/// h.
struct ActuatorModel {
  double gain = 1.0, dead_time_s = 0.0, lag_s = 0.0, damping = 1.0, lead_s = 0.0;
  double rms = 0.0;        ///< of output less model, in the output's unit
  double rms_plain = 0.0;  ///< of output less gain times command: what the model has to beat
};

/// Coefficients of the ARX model at a step of `step_s`, without the gain.
struct ArxCoefficients {
  double a1 = 0.0, a2 = 0.0, b0 = 0.0, b1 = 0.0;
};
ArxCoefficients arx_of(const ActuatorModel& model, double step_s);

/// Fits the model to samples of one stretch without gaps: least squares of the simulated output
/// (not of one-step predictions, which noise would bias), from a grid of beginnings, the command
/// straight between samples and simulated at 1 ms. Time ascends, s. Throws Error with fewer than 50
/// samples, a command that hardly moves, or values that are not finite.
ActuatorModel identify_actuator(const std::vector<double>& time_s,
                                const std::vector<double>& command,
                                const std::vector<double>& output);

}  // namespace vehicle
