#include "shifted_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace explain {
namespace {

/// The least way to an edge, by the direction in which the edge lies.
using ByDirection = std::array<double, 8>;

ByDirection least_ways(const std::vector<BetweenEdges>& path, double x_m, double y_m) {
  ByDirection least;
  least.fill(HUGE_VAL);
  for (const BetweenEdges& p : path) {
    const double left = x_m * p.to_left_x + y_m * p.to_left_y,
                 turn = std::atan2(p.to_left_y, p.to_left_x) / (2 * std::numbers::pi) + 1;
    const std::size_t k = static_cast<std::size_t>(turn * 8) % 8, opposite = (k + 4) % 8;
    least[k] = std::min(least[k], p.left_m - left);
    least[opposite] = std::min(least[opposite], p.right_m + left);
  }
  return least;
}

double least_way(const std::vector<BetweenEdges>& path, double x_m, double y_m) {
  double least = HUGE_VAL;
  for (const BetweenEdges& p : path) {
    const double left = x_m * p.to_left_x + y_m * p.to_left_y;
    least = std::min({least, p.left_m - left, p.right_m + left});
  }
  return least;
}

double scatter(const ByDirection& x) {
  double sum = 0.0, square = 0.0;
  for (const double v : x) sum += v / 8, square += v * v / 8;
  return std::sqrt(std::max(0.0, square - sum * sum));
}

/// The shift after which the least way to an edge is largest: a concave function, from coarse to
/// fine around the best.
PathShift widest_shift(const std::vector<BetweenEdges>& path) {
  PathShift out;
  out.least_before_m = out.least_after_m = least_way(path, 0.0, 0.0);
  for (double step_m = 4.0; step_m > 0.05; step_m *= 0.5) {
    const double x = out.x_m, y = out.y_m;
    for (int i = -3; i <= 3; ++i)
      for (int k = -3; k <= 3; ++k)
        if (const double least = least_way(path, x + i * step_m, y + k * step_m);
            least > out.least_after_m)
          out.x_m = x + i * step_m, out.y_m = y + k * step_m, out.least_after_m = least;
  }
  return out;
}

}  // namespace

std::optional<PathShift> shift_onto_road(const std::vector<BetweenEdges>& path) {
  // Drivers of four simulators and of a real car come as near to edges in every direction within
  // 0.4 m; the middle of a car is half a metre inside of its wheels at least.
  constexpr double kGained_m = 1.5, kInside_m = 1.0, kMended = 0.5;
  if (path.empty()) return std::nullopt;
  const PathShift shift = widest_shift(path);
  if (shift.least_after_m < kInside_m || shift.least_after_m - shift.least_before_m < kGained_m)
    return std::nullopt;
  // An edge in every direction, and what was uneven between them is gone.
  const double before = scatter(least_ways(path, 0.0, 0.0)),
               after = scatter(least_ways(path, shift.x_m, shift.y_m));
  if (!(after < kMended * before)) return std::nullopt;
  return shift;
}

}  // namespace explain
