#pragma once

#include <limits>

namespace cloud {

/// Of a node or a cell that has none.
inline constexpr float kNoValue = std::numeric_limits<float>::quiet_NaN();

}  // namespace cloud
