#include <cmath>

#include "fuzz/target.h"
#include "sim/message.h"

void fuzz::run(std::string_view bytes) {
  const std::vector<std::string> names{"input.throttle", "input.gear"};
  std::string why;
  const auto message = sim::read_command(bytes, names, why);
  require(message.has_value() == why.empty(), "a reason where it is refused");
  if (!message) return;
  require(message->values.size() == names.size(), "a value for every command");
  for (const double value : message->values)
    require(!std::isinf(value) && (!message->is_binary || std::isfinite(value)), "finite values");
  for (const std::string& name : {message->save, message->state})
    require(name.size() <= sim::kLongestStateName, "a bounded name of a state");
  require(message->save.empty() || !message->resets, "to save or to go back, not both");
  require(message->state.empty() || message->resets, "to go back is a reset");
  if (!message->plan) return;
  require(message->plan->size() <= sim::kMostPlanPoints, "a plan of a bounded size");
  for (const sim::PlanPoint& point : *message->plan)
    require(std::isfinite(point.x_m) && std::isfinite(point.y_m) && std::isfinite(point.speed_mps),
            "finite places");
}
