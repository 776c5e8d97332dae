// The car linearised at an operating point: its poles, and the steps that are stable there.
#pragma once

#include <vector>

#include "vehicle/step.h"

namespace vehicle {

struct Pole {
  double real_1ps = 0.0, imaginary_radps = 0.0;
  /// A purely explicit step is stable for this pole below this; infinite for an integrator (pole at
  /// zero), 0 for an unstable or undamped pole. Poles of sticking frictions do not bind either
  /// integrator: these act implicitly (settle.h).
  double euler_step_s = 0.0;
};

struct Linearisation {
  double speed_mps = 0.0;   ///< reached after settling
  std::vector<Pole> poles;  ///< fastest first
  /// Largest step of Integrator::kExplicitEuler, to 5 %, up to which no eigenvalue of a step is
  /// above 1; looked for from 0.2 to 10 ms, slow eigenvalues (within 1e-3 of 1) left out.
  double euler_step_s = 0.0;
  /// Largest magnitude of the eigenvalues of one step, without those within 1e-3 of 1, and how far
  /// the car swings at that step in the half second after settling (StepSwing::largest(); infinite
  /// where a step fails): frictions that stick and limits also swing where the eigenvalues of one
  /// point tell nothing.
  struct Radius {
    double step_s, explicit_euler, semi_implicit;
    double explicit_swing, semi_implicit_swing;
  };
  std::vector<Radius> radii;  ///< one per step asked for; above 1: oscillates or grows
};

/// Lets the car roll straight on the plane at `speed_mps` for two seconds with the throttle that
/// holds the speed, then linearises by central differences (relative error about 1e-6). Gear by
/// speed, neutral below 3 m/s.
Linearisation linearise(const Car<double>& car, double speed_mps,
                        const std::vector<double>& steps_s);

}  // namespace vehicle
