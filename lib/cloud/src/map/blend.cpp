#include "blend.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cloud {
namespace {

constexpr float kSteepest = 0.01f;  // of the ramp down to the base
constexpr float kFar = std::numeric_limits<float>::infinity();

bool rests_on(const MapResult& result, std::size_t k, NodeSource source) {
  return result.source.z_m[k] == static_cast<float>(source);
}

/// 1 beside what was measured, 0 from the width on; smooth.
float fading(float distance_m, float width_m) {
  const float far = std::min(distance_m / width_m, 1.0f);
  return 1.0f - far * far * (3.0f - 2.0f * far);
}

/// As far the base is taken to be as wrong as beside it.
float width_m(float moved_m, float blend_m) {
  return std::max(blend_m, 1.5f * std::abs(moved_m) / kSteepest);
}

/// Of each node the way to the nearest that was measured, and by how much that one moved.
struct Nearest {
  std::vector<float> distance_m, moved_m;
};

Nearest measured_nodes(const crg::Grid& base, const MapResult& result, std::ptrdiff_t rows,
                       std::ptrdiff_t columns) {
  Nearest out;
  out.distance_m.assign(static_cast<std::size_t>(rows * columns), kFar);
  out.moved_m.assign(out.distance_m.size(), 0.0f);
  const auto is_measured = [&](std::size_t k) {
    return rests_on(result, k, NodeSource::lidar) || rests_on(result, k, NodeSource::interpolated);
  };
  for (std::ptrdiff_t i = 0; i < rows; ++i)
    for (std::ptrdiff_t j = 0; j < columns; ++j) {
      const auto k = static_cast<std::size_t>(i * columns + j);
      if (!is_measured(k)) continue;
      out.distance_m[k] = 0.0f;
      float sum = 0.0f, count = 0.0f;  // single nodes are noisy
      for (std::ptrdiff_t a = std::max<std::ptrdiff_t>(0, i - 1); a <= std::min(i + 1, rows - 1);
           ++a)
        for (std::ptrdiff_t b = std::max<std::ptrdiff_t>(0, j - 1);
             b <= std::min(j + 1, columns - 1); ++b) {
          const auto n = static_cast<std::size_t>(a * columns + b);
          if (is_measured(n)) sum += result.grid.z_m[n] - base.z_m[n], count += 1.0f;
        }
      out.moved_m[k] = sum / count;
    }
  return out;
}

/// Carries distances from row to row.
class Sweep {
 public:
  Sweep(const RoadFrame& frame, std::ptrdiff_t rows, float widest_m, Nearest& nearest)
      : closed_(frame.closed()),
        rows_(rows),
        columns_(frame.columns()),
        u_step_m_(static_cast<float>(frame.u_step_m())),
        widest_m_(widest_m),
        nearest_(nearest) {
    for (std::size_t j = 0; j + 1 < columns_; ++j) {
      const auto across = static_cast<float>(frame.v_m()[j + 1] - frame.v_m()[j]);
      aside_m_.push_back(across);
      aslant_m_.push_back(std::sqrt(across * across + u_step_m_ * u_step_m_));
    }
  }

  /// A row from the one `before` it, and along itself. Unless one of them is near enough to
  /// something measured, nothing in it can be.
  void operator()(std::ptrdiff_t i, std::ptrdiff_t before, bool forth) {
    if (closed_) before = (before + rows_) % rows_;
    const bool has_before = before >= 0 && before < rows_;
    if (!is_near(i) && !(has_before && is_near(before))) return;
    const std::size_t here = static_cast<std::size_t>(i) * columns_,
                      there = static_cast<std::size_t>(before) * columns_;
    const auto from_before = [&](std::size_t j) {
      if (!has_before) return;
      if (forth) from_left(here, there, j, aslant_m_);
      if (!forth) from_right(here, there, j, aslant_m_);
      take(here + j, there + j, u_step_m_);
      if (forth) from_right(here, there, j, aslant_m_);
      if (!forth) from_left(here, there, j, aslant_m_);
    };
    if (forth)
      for (std::size_t j = 0; j < columns_; ++j) from_before(j), from_left(here, here, j, aside_m_);
    for (std::size_t j = columns_; j-- > 0;) {
      if (!forth) from_before(j);
      from_right(here, here, j, aside_m_);
    }
    if (!forth)
      for (std::size_t j = 0; j < columns_; ++j) from_left(here, here, j, aside_m_);
  }

 private:
  bool is_near(std::ptrdiff_t i) const {
    const auto row = nearest_.distance_m.begin() + i * static_cast<std::ptrdiff_t>(columns_);
    return std::any_of(row, row + static_cast<std::ptrdiff_t>(columns_),
                       [&](float far) { return far < widest_m_; });
  }
  void take(std::size_t k, std::size_t from, float step_m) {
    std::vector<float>& distance = nearest_.distance_m;
    if (distance[from] + step_m < distance[k])
      distance[k] = distance[from] + step_m, nearest_.moved_m[k] = nearest_.moved_m[from];
  }
  void from_left(std::size_t here, std::size_t there, std::size_t j,
                 const std::vector<float>& step_m) {
    if (j > 0) take(here + j, there + j - 1, step_m[j - 1]);
  }
  void from_right(std::size_t here, std::size_t there, std::size_t j,
                  const std::vector<float>& step_m) {
    if (j + 1 < columns_) take(here + j, there + j + 1, step_m[j]);
  }

  bool closed_;
  std::ptrdiff_t rows_;
  std::size_t columns_;
  float u_step_m_, widest_m_;
  Nearest& nearest_;
  std::vector<float> aside_m_, aslant_m_;  // from a column to the next, in a row and to the next
};

}  // namespace

void blend(const RoadFrame& frame, const crg::Grid& base, const MapOptions& options,
           MapResult& result) {
  const auto columns = static_cast<std::ptrdiff_t>(frame.columns()),
             rows = static_cast<std::ptrdiff_t>(frame.rows() - (frame.closed() ? 1 : 0));
  Nearest nearest = measured_nodes(base, result, rows, columns);
  const auto width = static_cast<float>(options.blend_m);
  float widest = width;
  for (const float m : nearest.moved_m) widest = std::max(widest, width_m(m, width));
  // Forth and back; on a closed road on over the seam.
  const auto beyond =
      frame.closed() ? std::min(rows, static_cast<std::ptrdiff_t>(widest / frame.u_step_m()) + 2)
                     : std::ptrdiff_t{0};
  Sweep sweep(frame, rows, widest, nearest);
  for (std::ptrdiff_t step = 0; step < rows + beyond; ++step)
    sweep(step % rows, step % rows - 1, true);
  for (std::ptrdiff_t step = rows + beyond; step-- > 0;) sweep(step % rows, step % rows + 1, false);
  for (std::size_t k = 0; k < nearest.distance_m.size(); ++k) {
    const float moved = nearest.moved_m[k];
    if (!rests_on(result, k, NodeSource::base) || nearest.distance_m[k] == kFar) continue;
    const float share = fading(nearest.distance_m[k], width_m(moved, width));
    if (!(share > 0.0f)) continue;
    result.stddev.z_m[k] = std::hypot(result.stddev.z_m[k], std::sqrt(share) * moved);
    result.grid.z_m[k] = base.z_m[k] + share * moved;
    result.source.z_m[k] = static_cast<float>(NodeSource::blended);
  }
}

}  // namespace cloud
