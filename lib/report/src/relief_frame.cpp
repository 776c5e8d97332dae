#include "relief_frame.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace report {
namespace {

constexpr int kMinWidth = 1300, kMinHeight = 900;  // px: header and footer fit

}  // namespace

Rgb height_colour(double share) {
  static constexpr std::array<Rgb, 6> kRamp{{{0.20f, 0.18f, 0.45f},
                                             {0.16f, 0.38f, 0.60f},
                                             {0.10f, 0.56f, 0.57f},
                                             {0.33f, 0.72f, 0.42f},
                                             {0.70f, 0.83f, 0.30f},
                                             {0.98f, 0.90f, 0.36f}}};
  const double at = std::clamp(share, 0.0, 1.0) * (kRamp.size() - 1);
  const std::size_t i = std::min<std::size_t>(static_cast<std::size_t>(at), kRamp.size() - 2);
  return mix(kRamp[i], kRamp[i + 1], static_cast<float>(at - static_cast<double>(i)));
}

XY direction_at(const ReliefInput& road, std::size_t row) {
  const std::size_t a = row == 0 ? 0 : row - 1, b = std::min(row + 1, road.x_m.size() - 1);
  const double dx = road.x_m[b] - road.x_m[a], dy = road.y_m[b] - road.y_m[a];
  const double length = std::hypot(dx, dy);
  return length > 0.0 ? XY{dx / length, dy / length} : XY{1.0, 0.0};
}

XY position_at(const ReliefInput& road, std::size_t row, double v_m) {
  const XY d = direction_at(road, row);
  return {road.x_m[row] - v_m * d.y, road.y_m[row] + v_m * d.x};
}

Extent extent_of(const ReliefInput& road, std::size_t row) {
  const std::size_t columns = road.v_m.size();
  const float* z = road.z_m.data() + row * columns;
  std::size_t first = 0, last = columns;
  while (first < columns && std::isnan(z[first])) ++first;
  while (last > first && std::isnan(z[last - 1])) --last;
  return first < last ? Extent{first, last - 1} : Extent{1, 0};
}

Bounds bounds_of(const ReliefInput& road, std::size_t row_stride) {
  Bounds b;
  for (std::size_t i = 0; i < road.x_m.size(); i += row_stride) {
    const Extent extent = extent_of(road, i);
    if (extent.empty()) continue;
    for (const std::size_t j : {extent.first, extent.last}) {
      const XY p = position_at(road, i, road.v_m[j]);
      if (!std::isfinite(p.x) || !std::isfinite(p.y)) continue;
      b.x_low = std::min(b.x_low, p.x);
      b.x_high = std::max(b.x_high, p.x);
      b.y_low = std::min(b.y_low, p.y);
      b.y_high = std::max(b.y_high, p.y);
    }
    const float* z = road.z_m.data() + i * road.v_m.size();
    for (std::size_t j = extent.first; j <= extent.last; ++j) {
      if (!(std::abs(z[j]) < 1e9f)) continue;
      b.z_low = std::min(b.z_low, z[j]);
      b.z_high = std::max(b.z_high, z[j]);
    }
  }
  return b;
}

Frame frame_of(const Bounds& b, int size_px) {
  const double w = std::max(b.x_high - b.x_low, 1.0), h = std::max(b.y_high - b.y_low, 1.0);
  const double room_x = size_px - 2.0 * kMargin, room_y = size_px - kHeader - kFooter;
  Frame frame;
  frame.px_per_m = std::min(room_x / w, room_y / h);
  frame.width = std::max(static_cast<int>(std::ceil(w * frame.px_per_m + 2.0 * kMargin)),
                         std::min(kMinWidth, size_px));
  frame.height = std::max(static_cast<int>(std::ceil(h * frame.px_per_m + kHeader + kFooter)),
                          std::min(kMinHeight, size_px));
  frame.left_px = (frame.width - w * frame.px_per_m) / 2.0;
  frame.top_px = kHeader + (frame.height - kHeader - kFooter - h * frame.px_per_m) / 2.0;
  frame.left_m = b.x_low;
  frame.top_m = b.y_high;
  return frame;
}

std::vector<std::size_t> every(std::size_t count, std::size_t stride) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < count; i += stride) out.push_back(i);
  if (out.back() != count - 1) out.push_back(count - 1);
  return out;
}

}  // namespace report
