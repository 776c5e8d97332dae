// What fits to the windows of a drive share.
#pragma once

#include <array>
#include <cstddef>
#include <set>
#include <vector>

#include "identify/drive_windows.h"
#include "vehicle/car.h"

namespace identify {

using Windows = std::vector<const DriveWindow*>;

inline std::size_t blocks_of(const Windows& windows) {
  std::set<std::size_t> out;
  for (const DriveWindow* w : windows) out.insert(w->block);
  return out.size();
}

/// A channel of the drive; nullptr: not recorded.
using Column = const std::vector<double>*;

/// How far the values of the vehicle file may be off, shares: two standard deviations.
using Prior = std::array<double, vehicle::kParameterCount>;

// Standard deviations of what no file states: rolling resistance as a share, an accelerometer's
// offset (5 thousandths of gravity).
inline constexpr double kRollingShare = 0.15, kOffset_mps2 = 0.05;

}  // namespace identify
