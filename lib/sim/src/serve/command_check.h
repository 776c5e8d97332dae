// What of a command is looked at before anything of it is done. Private to serve_unit.
#pragma once

#include <string>

#include "sim/message.h"
#include "sim/unit.h"

namespace sim {

/// Empty, or why the starts of a reset, or the state that a command saves or goes back to, are none
/// of the unit.
std::string wrong_with(const CommandMessage& message, const Unit& unit);

}  // namespace sim
