#include "directions.h"

#include <algorithm>
#include <cmath>

namespace crg {

std::size_t chord_segments(double u_step_m) {
  return static_cast<std::size_t>(std::clamp(std::round(0.5 / u_step_m), 1.0, 1e9));
}

bool chords_go_around(std::size_t rows, double u_step_m, bool joined) {
  return joined && 2 * chord_segments(u_step_m) < rows;
}

std::vector<Direction> directions_of(std::span<const SegmentRecord> nodes,
                                     std::span<const double> heading_rad, double u_step_m,
                                     bool joined) {
  const std::size_t last = nodes.size() - 1, half = chord_segments(u_step_m);
  const bool around = chords_go_around(nodes.size(), u_step_m, joined);
  const double chord = static_cast<double>(half) * u_step_m;
  std::vector<Direction> directions(last);
  for (std::size_t i = 0; i < last; ++i) {
    if (!around && (i < half || i + half > last)) {
      directions[i] = {i < half ? heading_rad.front() : heading_rad.back(), 0.0};
      continue;
    }
    const SegmentFrame& before = nodes[i >= half ? i - half : i + last - half].frame;
    const SegmentFrame& here = nodes[i].frame;
    const SegmentFrame& after = nodes[i + half <= last ? i + half : i + half - last].frame;
    const double x1 = here.x_m - before.x_m, y1 = here.y_m - before.y_m;
    const double x2 = after.x_m - here.x_m, y2 = after.y_m - here.y_m;
    directions[i] = {heading_rad[i + 1], (x1 * y2 - y1 * x2) / (chord * chord * chord)};
  }
  return directions;
}

}  // namespace crg
