#include "replay_windows.h"

#include <algorithm>
#include <cmath>

namespace vehicle {

std::size_t stretch_end(const recording::Recording& recording, const Window& window) {
  for (const recording::Stretch& stretch : recording.stretches)
    if (stretch.begin == window.stretch_begin) return stretch.end;
  return window.end;
}

std::vector<Window> cut(const recording::Recording& recording, const std::vector<double>& time,
                        const Channel& vx_mps, const ReplayOptions& options, ReplayResult& out) {
  std::vector<Window> windows;
  for (const recording::Stretch& stretch : recording.stretches) {
    const auto row_at = [&](double t) {
      const auto from = time.begin() + static_cast<std::ptrdiff_t>(stretch.begin);
      const auto to = time.begin() + static_cast<std::ptrdiff_t>(stretch.end);
      return static_cast<std::size_t>(std::lower_bound(from, to, t - 1e-9) - time.begin());
    };
    const double end_s = time[stretch.end - 1];
    double begin_s = time[stretch.begin] + options.settle_s;
    if (begin_s + kShortest_s > end_s) ++out.too_short;
    while (begin_s + kShortest_s <= end_s) {
      Window window{};
      window.stretch_begin = stretch.begin;
      window.first = row_at(begin_s);
      window.settle = row_at(time[window.first] - options.settle_s);
      begin_s = options.window_s > 0.0 ? time[window.first] + options.window_s : end_s;
      window.end = std::min(stretch.end, row_at(begin_s) + 1);
      double fastest = 0.0;
      for (std::size_t i = window.first; i < window.end; ++i)
        fastest = std::max(fastest, std::abs(vx_mps[i]));
      if (fastest < 1.0)
        ++out.standing;
      else
        windows.push_back(window);
    }
  }
  return windows;
}

}  // namespace vehicle
