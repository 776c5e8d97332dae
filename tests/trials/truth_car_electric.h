// The third car of the blind trials: electric, one gear, a body on four posts, one-pole actuators.
// It shares no equation with lib/vehicle, nor tyres and suspension with the second car.
#pragma once

#include "effects.h"

namespace trials {

/// Where its states lie; 0 to 5, 7, 8, 10, 11 and 16 are those of the second car.
enum ElectricState {
  kWheelFl = 6,
  kWheelRl = 7,
  kWheelRr = 8,
  kWheelFr = 17,
  kHeave,  ///< of the body against the road, up; then roll (to the right) and pitch (nose up)
  kHeaveRate = kHeave + 3,
  kSlip = kHeaveRate + 3,  ///< lagged lateral slip per wheel
  kSteered = kSlip + 4,    ///< what the actuators have reached
  kOpened,
  kPressed
};
static_assert(kPressed + 1 == std::tuple_size_v<State>);

TruthCar electric_car(TyreLaw tyre);

/// Torque of the motor: constant up to its base speed, then constant power; recuperates where the
/// pedal is free.
double motor_nm(const TruthCar& car, double omega, double throttle);

void electric_rates(const TruthCar& car, const Track& track, const State& x, const Commands& c,
                    double s, const Warp& warped, State& d, Output* out);

}  // namespace trials
