#include "blend.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace cloud {
namespace {

constexpr float kSteepest = 0.0099f;  // of the ramp down to the base; 1 % is not reached
constexpr double kAround_m = 2.0;
constexpr float kFar = std::numeric_limits<float>::infinity();

bool rests_on(const MapResult& result, std::size_t k, NodeSource source) {
  return result.source.z_m[k] == static_cast<float>(source);
}

bool is_measured(const MapResult& result, std::size_t k) {
  return rests_on(result, k, NodeSource::lidar) || rests_on(result, k, NodeSource::interpolated);
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

/// Of each node the way to the nearest that was measured, by how much that one moved, and how wrong
/// the base was seen to be in its row.
struct Nearest {
  std::vector<float> distance_m, moved_m, wrong_m;
};

/// What the base lacks at the edge of what was measured may have cancelled just there, as of a kerb
/// that is too low on a side that is too high: the most that a node nearby in the row moved.
float wrong_m(const crg::Grid& base, const MapResult& result, std::size_t row, std::size_t column) {
  const std::vector<double>& v_m = result.grid.v_m;
  const std::size_t columns = v_m.size();
  float most = 0.0f;
  const auto look = [&](std::size_t j) {
    const std::size_t n = row * columns + j;
    if (std::abs(v_m[j] - v_m[column]) > kAround_m) return false;
    if (is_measured(result, n)) most = std::max(most, std::abs(result.grid.z_m[n] - base.z_m[n]));
    return true;
  };
  for (std::size_t j = column; j < columns && look(j); ++j) continue;
  for (std::size_t j = column; j-- > 0 && look(j);) continue;
  return most;
}

Nearest measured_nodes(const crg::Grid& base, const MapResult& result, std::ptrdiff_t rows,
                       std::ptrdiff_t columns) {
  Nearest out;
  out.distance_m.assign(static_cast<std::size_t>(rows * columns), kFar);
  out.moved_m.assign(out.distance_m.size(), 0.0f), out.wrong_m = out.moved_m;
  for (std::ptrdiff_t i = 0; i < rows; ++i)
    for (std::ptrdiff_t j = 0; j < columns; ++j) {
      const auto k = static_cast<std::size_t>(i * columns + j);
      if (!is_measured(result, k)) continue;
      out.distance_m[k] = 0.0f;
      float sum = 0.0f, count = 0.0f;  // single nodes are noisy
      bool at_edge = false;
      for (std::ptrdiff_t a = std::max<std::ptrdiff_t>(0, i - 1); a <= std::min(i + 1, rows - 1);
           ++a)
        for (std::ptrdiff_t b = std::max<std::ptrdiff_t>(0, j - 1);
             b <= std::min(j + 1, columns - 1); ++b) {
          const auto n = static_cast<std::size_t>(a * columns + b);
          if (is_measured(result, n))
            sum += result.grid.z_m[n] - base.z_m[n], count += 1.0f;
          else
            at_edge = true;
        }
      out.moved_m[k] = sum / count;
      if (at_edge)
        out.wrong_m[k] = std::max(
            std::abs(out.moved_m[k]),
            wrong_m(base, result, static_cast<std::size_t>(i), static_cast<std::size_t>(j)));
    }
  return out;
}

/// From node to node, forth and back over the road; on a closed one on over the seam. Rows that
/// are as far from anything measured as `widest_m` are passed over.
class Sweep {
 public:
  Sweep(const crg::Grid& grid, bool closed, std::ptrdiff_t rows, float widest_m,
        const std::vector<float>& distance_m)
      : closed_(closed),
        rows_(rows),
        columns_(grid.columns()),
        u_step_m_(static_cast<float>(grid.u_step_m)),
        widest_m_(widest_m),
        distance_m_(distance_m) {
    for (std::size_t j = 0; j + 1 < columns_; ++j) {
      const auto across = static_cast<float>(grid.v_m[j + 1] - grid.v_m[j]);
      aside_m_.push_back(across);
      aslant_m_.push_back(std::sqrt(across * across + u_step_m_ * u_step_m_));
    }
  }

  /// Calls take(node, the one before it, the way between them).
  template <typename Take>
  void operator()(const Take& take) const {
    const auto beyond =
        closed_ ? std::min(rows_, static_cast<std::ptrdiff_t>(widest_m_ / u_step_m_) + 2)
                : std::ptrdiff_t{0};
    for (std::ptrdiff_t step = 0; step < rows_ + beyond; ++step)
      row(step % rows_, step % rows_ - 1, true, take);
    for (std::ptrdiff_t step = rows_ + beyond; step-- > 0;)
      row(step % rows_, step % rows_ + 1, false, take);
  }

 private:
  bool is_near(std::ptrdiff_t i) const {
    const auto row = distance_m_.begin() + i * static_cast<std::ptrdiff_t>(columns_);
    return std::any_of(row, row + static_cast<std::ptrdiff_t>(columns_),
                       [&](float far) { return far < widest_m_; });
  }
  /// A row from the one `before` it, and along itself. Unless one of them is near enough to
  /// something measured, nothing in it can be.
  template <typename Take>
  void row(std::ptrdiff_t i, std::ptrdiff_t before, bool forth, const Take& take) const {
    if (closed_) before = (before + rows_) % rows_;
    const bool has_before = before >= 0 && before < rows_;
    if (!is_near(i) && !(has_before && is_near(before))) return;
    const std::size_t here = static_cast<std::size_t>(i) * columns_,
                      there = static_cast<std::size_t>(before) * columns_;
    const auto from_left = [&](std::size_t from, std::size_t j, const std::vector<float>& step_m) {
      if (j > 0) take(here + j, from + j - 1, step_m[j - 1]);
    };
    const auto from_right = [&](std::size_t from, std::size_t j, const std::vector<float>& step_m) {
      if (j + 1 < columns_) take(here + j, from + j + 1, step_m[j]);
    };
    const auto from_before = [&](std::size_t j) {
      if (!has_before) return;
      if (forth) from_left(there, j, aslant_m_);
      if (!forth) from_right(there, j, aslant_m_);
      take(here + j, there + j, u_step_m_);
      if (forth) from_right(there, j, aslant_m_);
      if (!forth) from_left(there, j, aslant_m_);
    };
    if (forth)
      for (std::size_t j = 0; j < columns_; ++j) from_before(j), from_left(here, j, aside_m_);
    for (std::size_t j = columns_; j-- > 0;) {
      if (!forth) from_before(j);
      from_right(here, j, aside_m_);
    }
    if (!forth)
      for (std::size_t j = 0; j < columns_; ++j) from_left(here, j, aside_m_);
  }

  bool closed_;
  std::ptrdiff_t rows_;
  std::size_t columns_;
  float u_step_m_, widest_m_;
  const std::vector<float>& distance_m_;
  std::vector<float> aside_m_, aslant_m_;  // from a column to the next, in a row and to the next
};

/// A height that a node must reach so that no ramp from a measured one is too steep, and how far
/// that one is.
struct Reach {
  float height_m = 0.0f, far_m = kFar;
};

/// Between measured nodes that lie closer to each other than a ramp of such steepness needs:
/// straight from one to the other. Returns which nodes do.
std::vector<std::uint8_t> go_straight(const Sweep& sweep, const MapResult& result,
                                      std::vector<float>& added_m) {
  std::vector<Reach> least(added_m.size(), Reach{-kFar, kFar}),
      most(added_m.size(), Reach{kFar, kFar});
  for (std::size_t k = 0; k < added_m.size(); ++k)
    if (is_measured(result, k)) least[k] = most[k] = {added_m[k], 0.0f};
  sweep([&](std::size_t k, std::size_t from, float step_m) {
    if (is_measured(result, k)) return;
    const float low_m = least[from].height_m - kSteepest * step_m,
                high_m = most[from].height_m + kSteepest * step_m;
    if (low_m > least[k].height_m) least[k] = {low_m, least[from].far_m + step_m};
    if (high_m < most[k].height_m) most[k] = {high_m, most[from].far_m + step_m};
  });
  std::vector<std::uint8_t> straight(added_m.size(), 0);
  for (std::size_t k = 0; k < added_m.size(); ++k) {
    if (is_measured(result, k)) continue;
    const Reach &low = least[k], &high = most[k];
    straight[k] = low.height_m > high.height_m ? 1 : 0;
    if (straight[k] != 0)
      added_m[k] =
          (low.height_m * high.far_m + high.height_m * low.far_m) / (low.far_m + high.far_m);
    else
      added_m[k] = std::min(std::max(added_m[k], low.height_m), high.height_m);
  }
  return straight;
}

/// What is added to nodes that were not measured, without steps where the nearest measured one is
/// another: half way between the lowest and the highest that has no steeper ramp.
void take_out_steps(const Sweep& sweep, const MapResult& result, std::vector<float>& added_m) {
  const std::vector<std::uint8_t> straight = go_straight(sweep, result, added_m);
  std::vector<float> low_m = added_m, high_m = added_m;
  sweep([&](std::size_t k, std::size_t from, float step_m) {
    if (is_measured(result, k) || straight[k] != 0) return;
    low_m[k] = std::min(low_m[k], low_m[from] + kSteepest * step_m);
    high_m[k] = std::max(high_m[k], high_m[from] - kSteepest * step_m);
  });
  for (std::size_t k = 0; k < added_m.size(); ++k) added_m[k] = 0.5f * (low_m[k] + high_m[k]);
}

/// No steeper than a ramp from the measured nodes at a run's ends, of which there is one or two,
/// nor from node to node; straight between two that lie closer than that.
void level_run(const crg::Grid& grid, std::size_t row, std::size_t begin, std::size_t end,
               bool from_left, bool to_right, std::vector<float>& added_m) {
  const auto v = [&](std::size_t j) { return static_cast<float>(grid.v_m[j]); };
  float* const a = added_m.data() + row * grid.columns();
  const std::size_t left = begin - (from_left ? 1 : 0), right = end - (to_right ? 0 : 1);
  if (from_left && to_right && std::abs(a[right] - a[left]) > kSteepest * (v(right) - v(left))) {
    for (std::size_t j = begin; j < end; ++j)
      a[j] = a[left] + (a[right] - a[left]) * (v(j) - v(left)) / (v(right) - v(left));
    return;
  }
  for (std::size_t j = begin; j < end; ++j) {
    if (from_left)
      a[j] = std::clamp(a[j], a[left] - kSteepest * (v(j) - v(left)),
                        a[left] + kSteepest * (v(j) - v(left)));
    if (to_right)
      a[j] = std::clamp(a[j], a[right] - kSteepest * (v(right) - v(j)),
                        a[right] + kSteepest * (v(right) - v(j)));
  }
  std::vector<float> low_m(a + left, a + right + 1), high_m = low_m;
  const auto limit = [&](std::size_t j, std::size_t from) {
    const float most = kSteepest * std::abs(v(left + j) - v(left + from));
    low_m[j] = std::min(low_m[j], low_m[from] + most);
    high_m[j] = std::max(high_m[j], high_m[from] - most);
  };
  for (std::size_t j = 1; j < low_m.size(); ++j) limit(j, j - 1);
  for (std::size_t j = low_m.size() - 1; j-- > 0;) limit(j, j + 1);
  for (std::size_t j = begin; j < end; ++j) a[j] = 0.5f * (low_m[j - left] + high_m[j - left]);
}

/// Across, each row by itself: rows beside it have ends of their own, as noisy as single nodes.
void level_rows(const MapResult& result, std::vector<float>& added_m) {
  const std::size_t columns = result.grid.columns();
  for (std::size_t row = 0; row < result.grid.rows(); ++row)
    for (std::size_t j = 0; j < columns;) {
      const std::size_t begin = j;
      while (j < columns && !is_measured(result, row * columns + j)) ++j;
      if (j > begin && (begin > 0 || j < columns))
        level_run(result.grid, row, begin, j, begin > 0, j < columns, added_m);
      if (j == begin) ++j;
    }
}

/// Of all rows. `closed`: the first goes on from the last.
void blend_rows(const crg::Grid& base, bool closed, float width, float widest, MapResult& result) {
  const auto columns = static_cast<std::ptrdiff_t>(base.columns()),
             rows = static_cast<std::ptrdiff_t>(base.rows());
  Nearest nearest = measured_nodes(base, result, rows, columns);
  const Sweep sweep(base, closed, rows, widest, nearest.distance_m);
  sweep([&](std::size_t k, std::size_t from, float step_m) {
    std::vector<float>& distance_m = nearest.distance_m;
    if (distance_m[from] + step_m < distance_m[k])
      distance_m[k] = distance_m[from] + step_m, nearest.moved_m[k] = nearest.moved_m[from],
      nearest.wrong_m[k] = nearest.wrong_m[from];
  });
  std::vector<float> wanted_m(nearest.distance_m.size(), 0.0f);
  for (std::size_t k = 0; k < wanted_m.size(); ++k) {
    const float moved = nearest.moved_m[k];
    if (!rests_on(result, k, NodeSource::base))
      wanted_m[k] = result.grid.z_m[k] - base.z_m[k];
    else if (nearest.distance_m[k] < kFar)
      wanted_m[k] = fading(nearest.distance_m[k], width_m(moved, width)) * moved;
  }
  std::vector<float> added_m = wanted_m;
  take_out_steps(sweep, result, added_m);
  level_rows(result, added_m);
  for (std::size_t k = 0; k < added_m.size(); ++k) {
    if (!rests_on(result, k, NodeSource::base) || added_m[k] == 0.0f) continue;
    const float wrong = nearest.wrong_m[k],
                share = nearest.distance_m[k] < kFar
                            ? fading(nearest.distance_m[k], width_m(wrong, width))
                            : 0.0f;
    result.stddev.z_m[k] =
        std::hypot(result.stddev.z_m[k], std::sqrt(share) * wrong, added_m[k] - wanted_m[k]);
    result.grid.z_m[k] = base.z_m[k] + added_m[k];
    result.source.z_m[k] = static_cast<float>(NodeSource::blended);
  }
}

/// The widest that anything is blended over.
float widest_m(const crg::Grid& base, const MapResult& result, float width) {
  float widest = width;
  for (std::size_t k = 0; k < base.z_m.size(); ++k)
    if (is_measured(result, k))
      widest = std::max(widest, width_m(result.grid.z_m[k] - base.z_m[k], width));
  return widest;
}

/// 1: rows no farther from one with measured nodes than `reach` rows.
std::vector<std::uint8_t> rows_within(const MapResult& result, std::size_t rows, bool closed,
                                      std::size_t reach) {
  const std::size_t columns = result.grid.columns();
  std::vector<std::uint8_t> near(rows, 0);
  std::size_t end = 0;  // of the rows before which all that are near are marked
  for (std::size_t i = 0; i < rows; ++i) {
    bool measured = false;
    for (std::size_t j = 0; j < columns && !measured; ++j)
      measured = is_measured(result, i * columns + j);
    if (!measured) continue;
    for (std::size_t k = std::max(end, i - std::min(i, reach)); k <= i + reach; ++k)
      if (k < rows || closed) near[k % rows] = 1;
    end = std::min(rows, i + reach + 1);
    for (std::size_t k = i; closed && k < reach; ++k) near[(i + rows - k - 1) % rows] = 1;
  }
  return near;
}

/// Some rows of a grid from one on, on a closed road on over its end; and back again.
crg::Grid rows_of(const crg::Grid& grid, std::size_t first, std::size_t count, std::size_t rows) {
  crg::Grid out;
  out.u_step_m = grid.u_step_m, out.v_m = grid.v_m;
  const std::size_t columns = grid.columns();
  out.z_m.reserve(count * columns);
  for (std::size_t i = first; i < first + count; ++i) {
    const auto row = grid.z_m.begin() + static_cast<std::ptrdiff_t>(i % rows * columns);
    out.z_m.insert(out.z_m.end(), row, row + static_cast<std::ptrdiff_t>(columns));
  }
  return out;
}

void put_rows(const crg::Grid& part, std::size_t first, std::size_t rows, crg::Grid& grid) {
  const auto columns = static_cast<std::ptrdiff_t>(grid.columns());
  for (std::size_t i = 0; i < part.rows(); ++i)
    std::copy_n(part.z_m.begin() + static_cast<std::ptrdiff_t>(i) * columns, columns,
                grid.z_m.begin() + static_cast<std::ptrdiff_t>((first + i) % rows) * columns);
}

}  // namespace

void blend(const RoadFrame& frame, const crg::Grid& base, const MapOptions& options,
           MapResult& result) {
  const std::size_t rows = frame.rows() - (frame.closed() ? 1 : 0);
  const auto width = static_cast<float>(options.blend_m);
  const float widest = widest_m(base, result, width);
  const auto reach = std::min(
      rows - 1, static_cast<std::size_t>(static_cast<double>(widest) / frame.u_step_m()) + 2);
  const std::vector<std::uint8_t> near = rows_within(result, rows, frame.closed(), reach);
  const auto far = std::find(near.begin(), near.end(), std::uint8_t{0});
  const bool whole = far == near.end();
  // On a closed road a run may go on over its end: from a row that is far on, all round.
  const std::size_t begin =
      whole || !frame.closed() ? 0 : static_cast<std::size_t>(far - near.begin());
  for (std::size_t i = begin; i < begin + rows;) {
    std::size_t end = i;
    while (end < begin + rows && near[end % rows] == near[i % rows]) ++end;
    if (near[i % rows] != 0) {
      MapResult part;
      part.grid = rows_of(result.grid, i, end - i, rows);
      part.stddev = rows_of(result.stddev, i, end - i, rows);
      part.source = rows_of(result.source, i, end - i, rows);
      blend_rows(rows_of(base, i, end - i, rows), whole && frame.closed(), width, widest, part);
      put_rows(part.grid, i, rows, result.grid), put_rows(part.stddev, i, rows, result.stddev);
      put_rows(part.source, i, rows, result.source);
    }
    i = end;
  }
}

}  // namespace cloud
