// What an engine gives in the long run, as a driver judges it.
#pragma once

#include "vehicle/racing_line.h"

namespace vehicle {

/// Torque of the full turbocharged engine over engine speed, rad/s, and throttle, N m, once its air
/// path has settled: without limiter, idle control and engine.torque, as an engine map has it.
/// Empty for a car whose engine follows its map. Throws Error where the air path does not settle.
Map2 steady_engine(const Car<double>& car);

/// The engine as a driver on this line takes it.
inline const Map2& engine_map(const Car<double>& car, const RacingLine& line) {
  return line.engine_torque_nm.empty() ? car.files->engine_torque_nm : line.engine_torque_nm;
}

/// Throttle by which an engine of this map has a torque at a speed, 0 to 1; torques that fall with
/// the throttle count as those of the less open one.
double throttle_for(const Map2& torque_nm, double engine_radps, double torque);

}  // namespace vehicle
