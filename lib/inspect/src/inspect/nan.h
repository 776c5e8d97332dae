// What is not known. Private.
#pragma once

#include <limits>

namespace road {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr float kNanF = std::numeric_limits<float>::quiet_NaN();

}  // namespace road
