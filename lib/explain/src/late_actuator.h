// Findings about what acts late on a command, and which actuator of the car that is.
#pragma once

#include <string>
#include <vector>

#include "explain/signals.h"
#include "vehicle/parameters.h"

namespace explain {

struct LateActuator {
  const char* name;  ///< of the term
  vehicle::Term term;
  Channel channel;
  vehicle::Parameter gain, dead_time, lag, damping, lead;
};

/// Nothing for any other mechanism.
const LateActuator* late_actuator(const std::string& mechanism);

/// Whether a log has the command itself.
bool commanded(const std::vector<Signals>& logs, Channel c);

}  // namespace explain
