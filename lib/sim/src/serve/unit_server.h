// A unit in its own process, driven by a connection. Private to serve_unit.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "apart.h"
#include "connection.h"
#include "sim/serve_unit.h"
#include "sim/unit.h"
#include "together.h"

namespace sim {

/// Steps an initialised unit, the k-th of `together`, until the run ends for it. Says 'G' when it
/// is ready, 'R' with each row of the record, 'P' with each line of what was seen and planned, 'B'
/// with why the first broken command was refused, and at last 'S' with the ServeCounts.
void serve_by(const Connection& connection, Unit& unit, const std::string& path,
              const ServeOptions& options, Together& together, std::size_t k,
              const std::function<void(Words)>& say);

}  // namespace sim
