// The parts of a recording that are driven in one go. Private to replay.
#pragma once

#include <cstddef>
#include <vector>

#include "replay_commands.h"
#include "vehicle/replay.h"

namespace vehicle {

/// The shortest window, in seconds.
inline constexpr double kShortest_s = 0.1;

/// Part of the recording that is driven in one go.
struct Window {
  std::size_t stretch_begin, settle, first, end;  ///< rows; [settle, first) is not judged
};

/// The row past the stretch that the window lies in.
std::size_t stretch_end(const recording::Recording& recording, const Window& window);

/// Cuts the recording into windows; counts what cannot be one.
std::vector<Window> cut(const recording::Recording& recording, const std::vector<double>& time,
                        const Channel& vx_mps, const ReplayOptions& options, ReplayResult& out);

}  // namespace vehicle
