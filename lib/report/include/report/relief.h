// A plan view of a road as a shaded relief: colour is height, shading is slope.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace report {

/// The road as plain arrays; nothing is copied. rows = x_m.size(), columns = v_m.size().
struct ReliefInput {
  std::string title;
  double u_begin_m = 0.0;
  double u_step_m = 1.0;
  std::span<const double> x_m, y_m;  ///< nodes of the reference line
  std::span<const double> v_m;       ///< columns, ascending, left positive
  std::span<const float>
      z_m;  ///< rows * columns heights in the map frame, row after row; NaN: no road
  std::span<const std::uint8_t> kind;  ///< empty, or per node: 0 road, 1 kerb, 2 run-off
  double z_offset_m = 0.0;             ///< added to the heights in words and numbers
  bool closed = false;
};

struct ReliefOptions {
  int size_px = 2000;                ///< the longer side of the picture
  double light_azimuth_deg = 315.0;  ///< where the light comes from, clockwise from +y (map north)
  double light_altitude_deg = 45.0;
  double z_exaggeration = 5.0;  ///< of the shading only: road slopes are gentle
  unsigned threads = 0;         ///< 0 = all cores; any number gives the same bytes
};

/// The picture as the bytes of a PNG file. Throws std::invalid_argument when the arrays do not fit
/// each other or no node has a height.
std::string relief_png(const ReliefInput& road, const ReliefOptions& options = {});

}  // namespace report
