// What a recording asks of the car that drives it again. Private to replay.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "vehicle/replay.h"

namespace vehicle {

/// A channel without empty cells; empty where it was not recorded.
using Channel = std::vector<double>;

/// At time t between two rows, the first of them `row`; held beyond.
double at(const Channel& channel, const std::vector<double>& time, std::size_t row, double t);

/// The channels of a recording.
struct Source {
  const recording::Recording& recording;
  const std::vector<double>& time;

  /// Gaps filled; empty where it was not recorded.
  Channel channel(const std::string& name) const;
  /// Throws Error where it was not recorded.
  Channel need(const std::string& name) const;
};

/// What the recording asks of the car.
struct Commands {
  Channel steer_command_rad, throttle_command, gear, wake_x_m, wake_y_m;
  std::array<Channel, kWheels> brake_command_pa;
};

/// The commands, and the car without those actuators whose outcome was recorded.
Commands read_commands(const Source& source, const ReplayOptions& options, Car<double>& car,
                       std::vector<std::string>& said);

/// What the recording, or the driver, asks at time t; `row` is the recorded row before t.
Controls<double> controls_at(const Commands& commands, const std::vector<double>& time,
                             std::size_t row, double t, const Car<double>& car, double vx_mps,
                             int& gear);

}  // namespace vehicle
