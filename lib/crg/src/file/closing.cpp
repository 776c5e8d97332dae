#include "closing.h"

#include <cmath>

namespace crg {

std::optional<Closing> find_closing(const ReferenceLine& line) {
  if (line.size() < 4) return std::nullopt;
  const std::size_t last = line.size() - 1;
  const double end_heading = line.heading_rad[last];
  const double start_heading = line.heading_rad[0];
  const double dx = line.x_m[0] - line.x_m[last];
  const double dy = line.y_m[0] - line.y_m[last];
  const double cos_turn = std::cos(start_heading - end_heading);
  if (!(cos_turn >= 0.5)) return std::nullopt;

  const double gap = std::hypot(dx, dy);
  const double tolerance = 1e-4;  // CHECK_TOL: overlaps up to it count as a gap of zero
  // Where the two extended ends intersect, if they do so near the gap; else half of it each.
  const double c1 = std::cos(end_heading), s1 = std::sin(end_heading);
  const double c2 = std::cos(start_heading), s2 = std::sin(start_heading);
  const double det = s1 * c2 - c1 * s2;
  if (std::abs(det) > 1e-9) {
    const double after_end = (dy * c2 - dx * s2) / det;
    const double before_start = (c1 * dy - s1 * dx) / -det;
    if (after_end >= 0.0 && before_start >= 0.0 && after_end + before_start <= 2.0 * gap) {
      return Closing{before_start, after_end};
    }
  }
  const double forward = 0.5 * (dx * (c1 + c2) + dy * (s1 + s2));
  if (forward < -tolerance || std::abs(forward) < 0.5 * gap - tolerance) return std::nullopt;
  const double half = std::max(0.0, 0.5 * forward);
  return Closing{half, half};
}

Closing closing_of(const ReferenceLine& line) {
  return line.closed ? find_closing(line).value_or(Closing{}) : Closing{};
}

}  // namespace crg
