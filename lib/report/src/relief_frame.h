// Where the road lies in the picture of its relief, and its colours. Private to relief_png.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "report/relief.h"

namespace report {

// px
inline constexpr double kMargin = 70.0, kHeader = 120.0, kFooter = 150.0;

struct Rgb {
  float r, g, b;
};

inline constexpr Rgb kKerbRed{0.84f, 0.13f, 0.12f}, kKerbWhite{1.0f, 1.0f, 1.0f};
inline constexpr Rgb kRunoff{0.80f, 0.79f, 0.75f};
inline constexpr float kRunoffShare = 0.62f;

inline Rgb mix(const Rgb& a, const Rgb& b, float share) {
  return {a.r + (b.r - a.r) * share, a.g + (b.g - a.g) * share, a.b + (b.b - a.b) * share};
}

/// Dark to light with rising height, so that it also reads in grey. share in [0, 1].
Rgb height_colour(double share);

struct XY {
  double x, y;
};

/// Unit vector along the reference line at a node; its left normal is (-y, x).
XY direction_at(const ReliefInput& road, std::size_t row);

XY position_at(const ReliefInput& road, std::size_t row, double v_m);

/// Outermost columns with a height; first > last where the row has none.
struct Extent {
  std::size_t first, last;
  bool empty() const { return first > last; }
};

Extent extent_of(const ReliefInput& road, std::size_t row);

/// From the map to the picture; y of a picture points down.
struct Frame {
  double px_per_m = 1.0, left_m = 0.0, top_m = 0.0, left_px = 0.0, top_px = 0.0;
  int width = 0, height = 0;
  XY operator()(const XY& m) const {
    return {left_px + (m.x - left_m) * px_per_m, top_px + (top_m - m.y) * px_per_m};
  }
};

struct Bounds {
  double x_low = std::numeric_limits<double>::infinity(), x_high = -x_low;
  double y_low = x_low, y_high = -x_low;
  float z_low = std::numeric_limits<float>::infinity(), z_high = -z_low;
};

/// Of every `row_stride`th row.
Bounds bounds_of(const ReliefInput& road, std::size_t row_stride);
Frame frame_of(const Bounds& b, int size_px);

/// 0, stride, 2 stride ... and the last of `count`.
std::vector<std::size_t> every(std::size_t count, std::size_t stride);

}  // namespace report
