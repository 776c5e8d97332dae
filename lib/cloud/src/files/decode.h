// Values of binary records.
#pragma once

#include <functional>

#include "emitter.h"
#include "records.h"

namespace cloud {

/// So many points at once; `done` hears up to which byte the file is no longer needed.
void read_binary(const Records& records, std::size_t chunk_points, Emitter& emit,
                 const std::function<void(std::size_t)>& done);

}  // namespace cloud
