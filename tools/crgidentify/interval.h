// How wide the intervals of reports are.
#pragma once

namespace crgidentify {

inline constexpr double k90 = 1.645;  ///< standard deviations of a 90 % interval

}  // namespace crgidentify
