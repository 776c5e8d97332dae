#include "coarse_index.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace crg {

namespace {

// Between the neighbours of a station, for each segment.
float turn_at(std::span<const SegmentRecord> segments, std::size_t i, int shift) {
  const std::size_t around = std::size_t{1} << shift, begin = i < around ? 0 : i - around,
                    end = std::min(i + around, segments.size() - 1);
  if (begin == end) return 0.0F;
  const SegmentFrame &a = segments[begin].frame, &b = segments[end].frame;
  const double sine = std::clamp(a.cos * b.sin - a.sin * b.cos, -1.0, 1.0);
  return static_cast<float>(std::asin(sine) / static_cast<double>(end - begin));
}

}  // namespace

CoarseIndex::CoarseIndex(std::span<const SegmentRecord> segments, double reach_m)
    : segments_(segments.size()) {
  double x_max = -std::numeric_limits<double>::infinity(), y_max = x_max, length = 0.0;
  x_min_m_ = y_min_m_ = std::numeric_limits<double>::infinity();
  for (const SegmentRecord& segment : segments) {
    const SegmentFrame& frame = segment.frame;
    x_min_m_ = std::min(x_min_m_, frame.x_m);
    y_min_m_ = std::min(y_min_m_, frame.y_m);
    x_max = std::max(x_max, frame.x_m);
    y_max = std::max(y_max, frame.y_m);
    length += frame.length_m;
  }
  const double margin = std::clamp(reach_m, 1.0, 1e6);
  x_min_m_ -= margin;
  y_min_m_ -= margin;
  const double width = x_max + margin - x_min_m_, height = y_max + margin - y_min_m_;
  // Floats hold the offsets of stations to centimetres up to this extent; beyond it there are no
  // guesses.
  if (!(width < 1e5 && height < 1e5)) return;
  double cell = std::max(12.0, margin);
  const double most = 4096.0 + 4.0 * static_cast<double>(segments.size());
  while (std::ceil(width / cell) * std::ceil(height / cell) > most) cell *= 1.25;
  per_cell_ = 1.0 / cell;
  columns_ = static_cast<std::size_t>(std::ceil(width / cell));
  rows_ = static_cast<std::size_t>(std::ceil(height / cell));
  blocks_ = (columns_ + 3) / 4;
  cells_.assign(blocks_ * 16 * ((rows_ + 3) / 4), 0);
  std::vector<float> nearest(cells_.size(), std::numeric_limits<float>::infinity());

  // A station about every 3 m; it covers the cells within reach.
  const double mean = std::max(length / static_cast<double>(segments.size()), 1e-9);
  while (shift_ < 20 && mean * static_cast<double>(2U << shift_) < 4.0) ++shift_;
  mean_length_m_ = static_cast<float>(mean);
  for (std::size_t i = 0; i < segments.size(); i += std::size_t{1} << shift_) {
    const SegmentFrame& frame = segments[i].frame;
    const double dx = frame.x_m - x_min_m_, dy = frame.y_m - y_min_m_;
    stations_.push_back({static_cast<float>(dx), static_cast<float>(dy),
                         static_cast<float>(frame.cos / mean), static_cast<float>(frame.sin / mean),
                         turn_at(segments, i, shift_)});
    const double around = std::min(margin + cell, 3.0 * cell);
    const auto first = [&](double at) {
      return static_cast<std::size_t>(std::max(0.0, (at - around) * per_cell_));
    };
    const std::size_t column_end =
        std::min(columns_, static_cast<std::size_t>((dx + around) * per_cell_) + 1);
    const std::size_t row_end =
        std::min(rows_, static_cast<std::size_t>((dy + around) * per_cell_) + 1);
    for (std::size_t row = first(dy); row < row_end; ++row) {
      for (std::size_t column = first(dx); column < column_end; ++column) {
        const double ex = (static_cast<double>(column) + 0.5) * cell - dx,
                     ey = (static_cast<double>(row) + 0.5) * cell - dy;
        const float distance = static_cast<float>(ex * ex + ey * ey);
        const std::size_t k = cell_at(row, column);
        if (distance < nearest[k]) {
          nearest[k] = distance;
          cells_[k] = static_cast<std::uint32_t>(stations_.size());
        }
      }
    }
  }
}

}  // namespace crg
