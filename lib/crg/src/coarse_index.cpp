#include "coarse_index.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace crg {

CoarseIndex::CoarseIndex(const std::vector<SegmentFrame>& frames, double reach_m) {
  double x_max = -std::numeric_limits<double>::infinity(), y_max = x_max, length = 0.0;
  x_min_m_ = y_min_m_ = std::numeric_limits<double>::infinity();
  for (const SegmentFrame& frame : frames) {
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
  // Floats hold the offsets of stations to centimetres up to this extent; beyond it there are no guesses.
  if (!(width < 1e5 && height < 1e5)) return;
  double cell = std::max(8.0, margin);
  const double most = 4096.0 + 4.0 * static_cast<double>(frames.size());
  while (std::ceil(width / cell) * std::ceil(height / cell) > most) cell *= 1.5;
  per_cell_ = 1.0 / cell;
  columns_ = static_cast<std::size_t>(std::ceil(width / cell));
  rows_ = static_cast<std::size_t>(std::ceil(height / cell));
  cells_.assign(columns_ * rows_, 0);
  std::vector<float> nearest(cells_.size(), std::numeric_limits<float>::infinity());

  // A station about every 3 m; it covers the cells within reach.
  const double mean = length / static_cast<double>(frames.size());
  const std::size_t run = static_cast<std::size_t>(std::clamp(3.0 / std::max(mean, 1e-9), 1.0, 1e6));
  for (std::size_t i = 0; i < frames.size(); i += run) {
    const SegmentFrame& frame = frames[i];
    const double dx = frame.x_m - x_min_m_, dy = frame.y_m - y_min_m_;
    stations_.push_back({static_cast<float>(dx), static_cast<float>(dy), static_cast<float>(frame.cos), static_cast<float>(frame.sin),
                         static_cast<float>(1.0 / std::max(mean, 1e-9)), static_cast<std::uint32_t>(i)});
    const double around = std::min(margin + cell, 3.0 * cell);
    const auto first = [&](double at) { return static_cast<std::size_t>(std::max(0.0, (at - around) * per_cell_)); };
    const std::size_t column_end = std::min(columns_, static_cast<std::size_t>((dx + around) * per_cell_) + 1);
    const std::size_t row_end = std::min(rows_, static_cast<std::size_t>((dy + around) * per_cell_) + 1);
    for (std::size_t row = first(dy); row < row_end; ++row) {
      for (std::size_t column = first(dx); column < column_end; ++column) {
        const double ex = (static_cast<double>(column) + 0.5) * cell - dx, ey = (static_cast<double>(row) + 0.5) * cell - dy;
        const float distance = static_cast<float>(ex * ex + ey * ey);
        const std::size_t k = row * columns_ + column;
        if (distance < nearest[k]) {
          nearest[k] = distance;
          cells_[k] = static_cast<std::uint32_t>(stations_.size());
        }
      }
    }
  }
}

std::size_t CoarseIndex::guess(double x_m, double y_m) const noexcept {
  const double dx = x_m - x_min_m_, dy = y_m - y_min_m_;
  const double column = dx * per_cell_, row = dy * per_cell_;
  if (!(column >= 0.0 && row >= 0.0 && column < static_cast<double>(columns_) && row < static_cast<double>(rows_))) return kNone;
  const std::uint32_t cell = cells_[static_cast<std::size_t>(row) * columns_ + static_cast<std::size_t>(column)];
  if (cell == 0) return kNone;
  // Walk along the stations as if the line were straight, then interpolate the segment.
  std::size_t k = cell - 1;
  const float px = static_cast<float>(dx), py = static_cast<float>(dy);
  for (int step = 0; step < 4; ++step) {
    const Station& station = stations_[k];
    const float s = (px - station.dx_m) * station.cos + (py - station.dy_m) * station.sin;
    const float segments = s * station.per_metre;
    const bool last = k + 1 == stations_.size();
    const float run = last ? 1e6F : static_cast<float>(stations_[k + 1].segment - station.segment);
    if (segments >= 0.0F && segments < run) return station.segment + static_cast<std::size_t>(segments);
    if (segments < 0.0F ? k == 0 : last) break;
    segments < 0.0F ? --k : ++k;
  }
  return stations_[k].segment;
}

}  // namespace crg
