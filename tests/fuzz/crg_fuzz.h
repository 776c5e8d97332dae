// One run of the fuzz target: read, check, evaluate. Used by libFuzzer and by the replay of the
// corpus under ctest.
#pragma once

#include <cstddef>
#include <cstdint>

namespace crg::fuzz {

/// Aborts when a refused input is refused without naming file and place, when an accepted one
/// answers a height or gradient that is not finite where it says it is valid, when the answer
/// depends on the cursor, or when writing and reading back changes a value.
void run(const std::uint8_t* data, std::size_t size);

}  // namespace crg::fuzz
