#include "directions.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "line_geometry.h"

namespace crg {

std::vector<Direction> directions_of(const ReferenceLine& line) {
  const std::size_t last = line.size() - 1;
  const std::size_t half =
      static_cast<std::size_t>(std::clamp(std::round(0.5 / line.u_step_m), 1.0, 1e9));
  const bool around = ends_joined(line) && 2 * half < line.size();
  const double chord = static_cast<double>(half) * line.u_step_m;
  std::vector<Direction> directions(last);
  for (std::size_t i = 0; i < last; ++i) {
    if (!around && (i < half || i + half > last)) {
      directions[i] = {i < half ? line.heading_rad.front() : line.heading_rad.back(), 0.0};
      continue;
    }
    const std::size_t before = i >= half ? i - half : i + last - half;
    const std::size_t after = i + half <= last ? i + half : i + half - last;
    const double x1 = line.x_m[i] - line.x_m[before], y1 = line.y_m[i] - line.y_m[before];
    const double x2 = line.x_m[after] - line.x_m[i], y2 = line.y_m[after] - line.y_m[i];
    directions[i] = {line.heading_rad[i + 1], (x1 * y2 - y1 * x2) / (chord * chord * chord)};
  }
  return directions;
}

}  // namespace crg
