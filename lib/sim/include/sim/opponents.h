// Other cars on the road of a unit: recorded drives, replayed by time or by place.
#pragma once

#include <optional>
#include <string>

#include "vehicle/opponent.h"

namespace sim {

struct OpponentDrive {
  std::string name;         ///< for messages
  vehicle::Opponent drive;  ///< its places on the map over the time of the run
  /// The opponent is this far ahead of the car on the path that it drove, m, whatever the time;
  /// nothing: by time.
  std::optional<double> ahead_m;
};

/// FILE, a log of any maker with time_s, x_m, y_m (or car.x, car.y, as crgsim writes them);
/// FILE@2s: it is 2 s further in its drive than the run; FILE@30m: it stays 30 m ahead of the car
/// on its path. Either may be negative. Throws Error as recording::read_log_table() and
/// make_opponent() do.
OpponentDrive read_opponent(const std::string& said);

}  // namespace sim
