// Whoever drives by datagrams. Private to serve_unit.
#pragma once

#include "command_socket.h"
#include "connection.h"
#include "sim/serve_unit.h"

namespace sim {

/// Messages in the form of the last command that is answered. In lockstep, where `options` have
/// sensors that look at the road, a driver that is slow is waited for; sending throws Error when it
/// takes nothing for 10 s. Who says that it watches gets copies as JSON, and is never waited for.
Connection connection_by(CommandSocket& socket, const ServeOptions& options);

}  // namespace sim
