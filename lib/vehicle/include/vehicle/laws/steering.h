// From the angle at the steering to that of the road wheels: a constant ratio, or a map of the
// rack.
#pragma once

#include "vehicle/map.h"

namespace vehicle::laws {

/// Mean angle of the road wheels that a command asks for: the command over the ratio. With a map of
/// the rack (road wheel angle over command, both rad) it is the map's over the ratio, which then
/// stands near 1. The map is straight between its places; beyond its ends the rack is at its stop.
template <class T>
T road_wheel_angle(const Map1& rack, const T& ratio, const T& command_rad) {
  if (rack.empty()) return T(command_rad / ratio);
  return T(evaluate(rack, command_rad) / ratio);
}

/// The command for a mean angle of the road wheels: the inverse; beyond the stops that of the stop.
/// Precondition: the map's values ascend (check_car).
inline double steering_command(const Map1& rack, double ratio, double road_wheel_rad) {
  const double wanted_rad = ratio * road_wheel_rad;
  if (rack.empty()) return wanted_rad;
  const auto at = map_detail::place(rack.y, wanted_rad);
  return rack.x[at.cell] + at.fraction * (rack.x[at.cell + 1] - rack.x[at.cell]);
}

}  // namespace vehicle::laws
