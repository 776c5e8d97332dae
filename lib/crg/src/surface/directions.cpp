#include "directions.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace crg {
namespace {

// How many segments a chord is long, and whether every row has both its chords: on a line whose
// last row repeats the first, if it is long enough.
struct Chords {
  std::size_t segments;
  bool around;

  Chords(std::size_t rows, double u_step_m, bool joined)
      : segments(static_cast<std::size_t>(std::clamp(std::round(0.5 / u_step_m), 1.0, 1e9))),
        around(joined && 2 * segments < rows) {}
};

}  // namespace

std::vector<double> Headings::of_line_rad() const {
  std::vector<double> out = of_row_rad;
  std::copy(first_rad.begin(), first_rad.end(), out.begin());
  std::copy_backward(last_rad.begin(), last_rad.end(), out.end());
  return out;
}

Headings headings_of(std::vector<double> of_row_rad, double u_step_m, bool joined) {
  const std::size_t rows = of_row_rad.size();
  const Chords chords(rows, u_step_m, joined);
  if (chords.around) return {std::move(of_row_rad), {}, {}};
  // Where a line is shorter than its two chords, its beginning counts first.
  const std::size_t first = std::min(chords.segments + 1, rows),
                    last = std::min(chords.segments - 1, rows - first);
  const auto first_end = of_row_rad.begin() + static_cast<std::ptrdiff_t>(first);
  const auto last_begin = of_row_rad.end() - static_cast<std::ptrdiff_t>(last);
  Headings headings{{}, {of_row_rad.begin(), first_end}, {last_begin, of_row_rad.end()}};
  std::fill(of_row_rad.begin(), first_end, headings.first_rad.front());
  if (last > 0) std::fill(last_begin, of_row_rad.end(), headings.last_rad.back());
  headings.of_row_rad = std::move(of_row_rad);
  return headings;
}

std::vector<double> curvatures_of(std::span<const SegmentRecord> nodes, double u_step_m,
                                  bool joined) {
  const Chords chords(nodes.size(), u_step_m, joined);
  const std::size_t last = nodes.size() - 1, half = chords.segments;
  const double chord = static_cast<double>(half) * u_step_m;
  std::vector<double> curvatures_1pm(last);
  for (std::size_t i = 0; i < last; ++i) {
    if (!chords.around && (i < half || i + half > last)) continue;
    const SegmentFrame& before = nodes[i >= half ? i - half : i + last - half].frame;
    const SegmentFrame& here = nodes[i].frame;
    const SegmentFrame& after = nodes[i + half <= last ? i + half : i + half - last].frame;
    const double x1 = here.x_m - before.x_m, y1 = here.y_m - before.y_m;
    const double x2 = after.x_m - here.x_m, y2 = after.y_m - here.y_m;
    curvatures_1pm[i] = (x1 * y2 - y1 * x2) / (chord * chord * chord);
  }
  return curvatures_1pm;
}

}  // namespace crg
