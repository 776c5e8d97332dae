#pragma once

#include <limits>

namespace explain {

/// A value that is not known.
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace explain
