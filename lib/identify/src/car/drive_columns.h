// The channels of a recorded drive as fits of parts of the car look at them.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "recording/table.h"
#include "vehicle/car.h"

namespace identify {

/// A channel; nullptr: not recorded.
using Column = const std::vector<double>*;

/// NaN where the channel is not there.
double at(Column column, std::size_t row);

/// Those of four wheels are there all, or none.
struct DriveColumns {
  Column time, x, y, z, yaw, vx, vy, rate, ax, ay, az, throttle, gear;
  std::array<Column, vehicle::kWheels> load, travel, wheel, brake, disc;
};
DriveColumns columns_of(const recording::Table& table);

/// Standard deviation of white noise on the values of a channel that is smooth otherwise, by its
/// third differences; NaN are skipped, 0 where there are fewer than 20 values.
double noise_of(const std::vector<double>& values);

/// What a lap repeats is one observation: places of the road, or near in time.
struct Blocks {
  double edge_m, edge_s;  ///< the second where no place was recorded
  std::map<std::pair<long, long>, std::size_t> known{};

  std::size_t of(double x_m, double y_m, double since_begin_s);
};

}  // namespace identify
