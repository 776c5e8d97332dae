// Other cars on the same road, as recorded or simulated before: where they are at a time.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "recording/table.h"
#include "vehicle/state.h"

namespace vehicle {

/// The path of a car over the time of this run; before its first and after its last row it is not
/// on the road.
struct Opponent {
  std::vector<double> time_s, x_m, y_m;  ///< ascending times; place in the frame of the road
};

/// The opponent of a log with `time_s`, `x_m` and `y_m` (telemetry of a run, or a recording), which
/// this run meets `ahead_s` seconds of its path after the log's begin. Throws Error naming `name`
/// where a channel is missing, fewer than two rows have all three, or times do not ascend.
Opponent make_opponent(const recording::Table& log, double ahead_s, const std::string& name);

/// An opponent's place in a car's body frame.
struct Wake {
  double x_m, y_m;
};

/// Where another car is, map frame.
struct OpponentPlace {
  double x_m, y_m;
};

/// Of these cars the nearest one ahead of the car; where none is ahead, the nearest; empty where
/// there is none. Allocates nothing.
std::optional<Wake> nearest_wake(std::span<const OpponentPlace> places, const State<double>& state);

/// The same of all opponents on the road at `time_s` and of cars that are at `places` now.
std::optional<Wake> nearest_wake(std::span<const Opponent> opponents, double time_s,
                                 std::span<const OpponentPlace> places, const State<double>& state);

/// Of all opponents on the road at `time_s` the nearest one ahead of the car; where none is ahead,
/// the nearest; empty where none is on the road. Allocates nothing.
std::optional<Wake> nearest_wake(std::span<const Opponent> opponents, double time_s,
                                 const State<double>& state);

}  // namespace vehicle
