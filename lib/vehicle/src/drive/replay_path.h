// What leads a replayed car back to its recorded path. Private to replay.
#pragma once

#include <cstddef>
#include <vector>

#include "replay_commands.h"
#include "vehicle/driver.h"
#include "vehicle/racing_line.h"

namespace vehicle {

/// The recorded path as a line to follow, a station every metre at least.
RacingLine recorded_line(const std::vector<double>& x, const std::vector<double>& y,
                         const std::vector<double>& speed, const recording::Stretch& stretch);

/// The recorded steering at the recorded place nearest to the car, and what leads back to the path:
/// the arc that takes away the offset of a point ahead.
struct PathKeeper {
  const Channel &x_m, &y_m, &yaw_rad, &steer_rad;
  std::size_t row, end;

  double steer(const Car<double>& car, const State<double>& s, const DriverOptions& options);
};

/// The driver who steers along the line, where the window begins.
Driver driver_at(const RacingLine& line, double x_m, double y_m, int gear,
                 const DriverOptions& options);

}  // namespace vehicle
