// Many points with one cursor: one after the other along a path, fetched ahead where they jump.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "height.h"
#include "locator.h"

namespace crg {

/// Cursors for points without a history, and everything that queries there will need asked for:
/// first the segments that the tables point at, then those beside which the points lie, and their
/// cells. The wait for one point's memory passes while others are looked at.
template <typename PointAt>
void fetch_ahead(const Locator& locator, const HeightField& heights, const PointAt& point_at,
                 std::span<Cursor> cursors) noexcept {
  for (std::size_t k = 0; k < cursors.size(); ++k) {
    const Point2 point = point_at(k);
    const CoarseIndex::Guess guess = locator.guess(point.x_m, point.y_m);
    cursors[k] = {};
    if (guess.segment == CoarseIndex::kNone) continue;
    cursors[k] = middle_of(guess.segment);
    __builtin_prefetch(locator.records() + guess.segment);
  }
  for (std::size_t k = 0; k < cursors.size(); ++k) {
    const std::size_t guess = segment_ahead(cursors[k]);
    if (guess >= locator.segments()) continue;
    const SegmentFrame& frame = locator.records()[guess].frame;
    const Point2 point = point_at(k);
    const Local local(frame, point.x_m, point.y_m);
    const double steps = std::floor(local.past_begin_m / frame.width(local.v_m));
    const double moved = static_cast<double>(guess) + steps;
    const bool near =
        std::abs(steps) < 64.0 && moved >= 0.0 && moved < static_cast<double>(locator.segments());
    const std::size_t segment = near ? static_cast<std::size_t>(moved) : guess;
    cursors[k] = middle_of(segment);
    const float* node = heights.node(segment, 0) + heights.column_near(local.v_m);
    __builtin_prefetch(locator.records() + segment);
    __builtin_prefetch(node);
    __builtin_prefetch(node + heights.columns());
    __builtin_prefetch(heights.line() + segment);
  }
}

/// out[k] for point_at(k), `count` of them. `ahead(point, cursor, answer)` answers where the cursor
/// leads, or is false; `jump(point, cursor)` answers anywhere. Neither answer may depend on the
/// cursor.
template <typename PointAt, typename Answer, typename Ahead, typename Jump>
void for_each_place(const Locator& locator, const HeightField& heights, std::size_t count,
                    const PointAt& point_at, Answer* out, Cursor& cursor, const Ahead& ahead,
                    const Jump& jump) noexcept {
  constexpr std::size_t kAtOnce = 32;
  for (std::size_t k = 0; k < count;) {
    if (ahead(point_at(k), cursor, out[k])) {
      ++k;
      continue;
    }
    Cursor cursors[kAtOnce];
    const std::size_t block = std::min(kAtOnce, count - k);
    if (block > 1) {
      fetch_ahead(
          locator, heights, [&](std::size_t j) { return point_at(k + j); },
          std::span<Cursor>(cursors, block));
    } else {
      cursors[0] = cursor;
    }
    for (std::size_t j = 0; j < block; ++j) out[k + j] = jump(point_at(k + j), cursors[j]);
    cursor = cursors[block - 1];
    k += block;
  }
}

}  // namespace crg
