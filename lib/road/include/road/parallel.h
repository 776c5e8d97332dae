#pragma once

#include <cstddef>
#include <functional>

namespace road {

/// Calls body(begin, end) for consecutive chunks of [0, count) on `threads` threads (0 = all cores).
/// Chunk borders depend on `count` and `chunk` only, so results written by index are the same for any
/// number of threads. The first exception thrown by a body is rethrown after all threads stopped.
void parallel_for(std::size_t count, std::size_t chunk, unsigned threads,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

}  // namespace road
