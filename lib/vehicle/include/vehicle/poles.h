// The car linearised at an operating point: its poles, and the steps that are stable there.
#pragma once

#include <vector>

#include "vehicle/step.h"

namespace vehicle {

struct Pole {
  double real_1ps = 0.0, imaginary_radps = 0.0;
  /// Explicit Euler is stable for this pole below this step; infinite for an integrator (pole at
  /// zero), 0 for an unstable or undamped pole.
  double euler_step_s = 0.0;
};

struct Linearisation {
  double speed_mps = 0.0;   ///< reached after settling
  std::vector<Pole> poles;  ///< fastest first
  double euler_step_s =
      0.0;  ///< smallest of all but the slow ones (below 1 / s), which every step survives
  /// Largest magnitude of the eigenvalues of one step, without those within 1e-3 of 1.
  struct Radius {
    double step_s, explicit_euler, semi_implicit;
  };
  std::vector<Radius> radii;  ///< one per step asked for; above 1: oscillates or grows
};

/// Lets the car roll straight on the plane at `speed_mps` for two seconds with the throttle that
/// holds the speed, then linearises by central differences (relative error about 1e-6). Gear by
/// speed, neutral below 3 m/s.
Linearisation linearise(const Car<double>& car, double speed_mps,
                        const std::vector<double>& steps_s);

}  // namespace vehicle
