// What the third car of the blind trials has beyond the figures that both cars have.
#pragma once

#include <array>

namespace trials {

enum class TyreLaw { kBrush, kTable };

struct Electric {
  TyreLaw tyre = TyreLaw::kBrush;
  // Four posts, per axle: springs and bars at the wheel in series with the tyre.
  std::array<double, 2> spring{90000, 100000}, bar{40000, 15000}, damping{9000, 9500};
  double tyre_npm = 240000, roll_inertia = 220, pitch_inertia = 1050;
  bool levelled = false;      ///< its accelerometers; else they lean with the body
  double drag_height = 0.42;  ///< m above the road
  double base_radps = 780;    ///< of the motor: above it, torque falls with the speed
  // Time constants of one-pole actuators; all that lies between driver and wheels, motor, pads.
  double steer_s = 0.03, throttle_s = 0.05, brake_s = 0.04;
};

}  // namespace trials
