#include "sim/opponents.h"

#include "recording/log_table.h"
#include "recording/table.h"
#include "vehicle/said_opponent.h"

namespace sim {
OpponentDrive read_opponent(const std::string& said) {
  const auto [path, ahead_s, ahead_m] = vehicle::said_opponent(said);
  recording::Table log = recording::read_log_table(path);
  if (log.find("x_m") == nullptr && log.find("y_m") == nullptr)
    for (std::string& name : log.names) {
      if (name == "car.x") name = "x_m";
      if (name == "car.y") name = "y_m";
    }
  return {path, vehicle::make_opponent(log, ahead_s.value_or(0.0), path), ahead_m};
}

}  // namespace sim
