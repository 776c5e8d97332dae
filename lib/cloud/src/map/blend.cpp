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
  const auto u_step = static_cast<float>(frame.u_step_m()),
             width = static_cast<float>(options.blend_m);
  float widest = width;
  for (const float m : moved) widest = std::max(widest, width_m(m, width));
  // From a column to the next, in a row and to the next one.
  std::vector<float> aside_m, aslant_m;
  for (std::size_t j = 0; j + 1 < frame.columns(); ++j) {
    const auto across = static_cast<float>(frame.v_m()[j + 1] - frame.v_m()[j]);
    aside_m.push_back(across);
    aslant_m.push_back(std::sqrt(across * across + u_step * u_step));
  }
  const auto take = [&](std::size_t k, std::size_t from, float step_m) {
    if (distance[from] + step_m < distance[k])
      distance[k] = distance[from] + step_m, moved[k] = moved[from];
  };
  const auto is_near = [&](std::ptrdiff_t i) {
    const auto row = distance.begin() + i * columns;
    return std::any_of(row, row + columns, [&](float far) { return far < widest; });
  };
  // A row from the one `before` it in a sweep, and along itself. Unless one of them is near enough
  // to something measured, nothing in it can be.
  const auto sweep = [&](std::ptrdiff_t i, std::ptrdiff_t before, bool forth) {
    if (frame.closed()) before = (before + rows) % rows;
    const bool has_before = before >= 0 && before < rows;
    if (!is_near(i) && !(has_before && is_near(before))) return;
    const auto here = static_cast<std::size_t>(i * columns),
               there = static_cast<std::size_t>(before * columns), n = frame.columns();
    const auto from_left = [&](std::size_t j) {
      if (j > 0) take(here + j, here + j - 1, aside_m[j - 1]);
    };
    const auto from_right = [&](std::size_t j) {
      if (j + 1 < n) take(here + j, here + j + 1, aside_m[j]);
    };
    const auto from_before = [&](std::size_t j) {
      const auto left = [&] {
        if (j > 0) take(here + j, there + j - 1, aslant_m[j - 1]);
      };
      if (!has_before) return;
      if (forth) left();
      if (!forth && j + 1 < n) take(here + j, there + j + 1, aslant_m[j]);
      take(here + j, there + j, u_step);
      if (forth && j + 1 < n) take(here + j, there + j + 1, aslant_m[j]);
      if (!forth) left();
    };
    if (forth)
      for (std::size_t j = 0; j < n; ++j) from_before(j), from_left(j);
    for (std::size_t j = n; j-- > 0;) {
      if (!forth) from_before(j);
      from_right(j);
    }
    if (!forth)
      for (std::size_t j = 0; j < n; ++j) from_left(j);
  };
  // Forth and back; on a closed road on over the seam.
  const auto beyond = frame.closed()
                          ? std::min(rows, static_cast<std::ptrdiff_t>(widest / u_step) + 2)
                          : std::ptrdiff_t{0};
  for (std::ptrdiff_t step = 0; step < rows + beyond; ++step)
    sweep(step % rows, step % rows - 1, true);
  for (std::ptrdiff_t step = rows + beyond; step-- > 0;) sweep(step % rows, step % rows + 1, false);
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
