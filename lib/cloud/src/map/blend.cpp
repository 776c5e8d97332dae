#include "blend.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cloud {
namespace {

constexpr float kSteepest = 0.01f;  // of the ramp down to the base

/// 1 beside what was measured, 0 from the width on; smooth.
float fading(float distance_m, float width_m) {
  const float far = std::min(distance_m / width_m, 1.0f);
  return 1.0f - far * far * (3.0f - 2.0f * far);
}

/// As far the base is taken to be as wrong as beside it.
float width_m(float moved_m, float blend_m) {
  return std::max(blend_m, 1.5f * std::abs(moved_m) / kSteepest);
}

}  // namespace

void blend(const RoadFrame& frame, const crg::Grid& base, const MapOptions& options,
           MapResult& result) {
  const auto columns = static_cast<std::ptrdiff_t>(frame.columns()),
             rows = static_cast<std::ptrdiff_t>(frame.rows() - (frame.closed() ? 1 : 0));
  constexpr float kFar = std::numeric_limits<float>::infinity();
  std::vector<float> distance(static_cast<std::size_t>(rows * columns), kFar),
      moved(distance.size());
  const auto rests_on = [&](std::size_t k, NodeSource source) {
    return result.source.z_m[k] == static_cast<float>(source);
  };
  for (std::ptrdiff_t i = 0; i < rows; ++i)
    for (std::ptrdiff_t j = 0; j < columns; ++j) {
      const auto k = static_cast<std::size_t>(i * columns + j);
      if (!rests_on(k, NodeSource::lidar) && !rests_on(k, NodeSource::interpolated)) continue;
      distance[k] = 0.0f;
      float sum = 0.0f, count = 0.0f;  // single nodes are noisy
      for (std::ptrdiff_t a = std::max<std::ptrdiff_t>(0, i - 1); a <= std::min(i + 1, rows - 1);
           ++a)
        for (std::ptrdiff_t b = std::max<std::ptrdiff_t>(0, j - 1);
             b <= std::min(j + 1, columns - 1); ++b) {
          const auto n = static_cast<std::size_t>(a * columns + b);
          if (rests_on(n, NodeSource::lidar) || rests_on(n, NodeSource::interpolated))
            sum += result.grid.z_m[n] - base.z_m[n], count += 1.0f;
        }
      moved[k] = sum / count;
    }
  const auto u_step = static_cast<float>(frame.u_step_m());
  const auto take = [&](std::ptrdiff_t i, std::ptrdiff_t j, std::ptrdiff_t from_i,
                        std::ptrdiff_t from_j) {
    if (from_j < 0 || from_j >= columns) return;
    if (frame.closed()) from_i = (from_i + rows) % rows;
    if (from_i < 0 || from_i >= rows) return;
    const auto k = static_cast<std::size_t>(i * columns + j),
               from = static_cast<std::size_t>(from_i * columns + from_j);
    const float across = static_cast<float>(frame.v_m()[static_cast<std::size_t>(j)] -
                                            frame.v_m()[static_cast<std::size_t>(from_j)]);
    const float step = std::sqrt(across * across + (from_i == i ? 0.0f : u_step * u_step));
    if (distance[from] + step < distance[k])
      distance[k] = distance[from] + step, moved[k] = moved[from];
  };
  const auto width = static_cast<float>(options.blend_m);
  float widest = width;
  for (const float m : moved) widest = std::max(widest, width_m(m, width));
  // Forth and back; on a closed road on over the seam.
  const auto beyond = frame.closed()
                          ? std::min(rows, static_cast<std::ptrdiff_t>(widest / u_step) + 2)
                          : std::ptrdiff_t{0};
  for (std::ptrdiff_t step = 0; step < rows + beyond; ++step) {
    const std::ptrdiff_t i = step % std::max<std::ptrdiff_t>(rows, 1);
    for (std::ptrdiff_t j = 0; j < columns; ++j)
      for (const auto& [a, b] : {std::pair{-1, -1}, {-1, 0}, {-1, 1}, {0, -1}})
        take(i, j, i + a, j + b);
    for (std::ptrdiff_t j = columns; j-- > 0;) take(i, j, i, j + 1);
  }
  for (std::ptrdiff_t step = rows + beyond; step-- > 0;) {
    const std::ptrdiff_t i = step % std::max<std::ptrdiff_t>(rows, 1);
    for (std::ptrdiff_t j = columns; j-- > 0;)
      for (const auto& [a, b] : {std::pair{1, 1}, {1, 0}, {1, -1}, {0, 1}})
        take(i, j, i + a, j + b);
    for (std::ptrdiff_t j = 0; j < columns; ++j) take(i, j, i, j - 1);
  }
  for (std::size_t k = 0; k < distance.size(); ++k) {
    if (!rests_on(k, NodeSource::base) || distance[k] == kFar) continue;
    const float share = fading(distance[k], width_m(moved[k], width));
    if (!(share > 0.0f)) continue;
    result.stddev.z_m[k] = std::hypot(result.stddev.z_m[k], std::sqrt(share) * moved[k]);
    result.grid.z_m[k] = base.z_m[k] + share * moved[k];
    result.source.z_m[k] = static_cast<float>(NodeSource::blended);
  }
}

}  // namespace cloud
