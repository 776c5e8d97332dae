#pragma once

#include <cstddef>
#include <functional>

namespace base {

/// Calls body(begin, end) for consecutive chunks of [0, count) on `threads` threads (0 = all
/// cores). Chunk borders depend on `count` and `chunk` only, so results written by index are the
/// same for any number of threads. After an exception no further chunk is begun; that of the lowest
/// chunk is rethrown once all threads have stopped.
void parallel_for(std::size_t count, std::size_t chunk, unsigned threads,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

}  // namespace base
