#include "road/crossings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace road {

namespace {

constexpr double kPiece_m = 2.0;  // the line is looked at in straight pieces of about this length
constexpr double kSameLevel_m = 0.1;

/// How far along p -> p2 it meets q -> q2, as a share of each; outside [0, 1) when it does not.
std::pair<double, double> meeting(const crg::Point2& p, const crg::Point2& p2, const crg::Point2& q,
                                  const crg::Point2& q2) {
  const double ax = p2.x_m - p.x_m, ay = p2.y_m - p.y_m, bx = q2.x_m - q.x_m, by = q2.y_m - q.y_m;
  const double area = ax * by - ay * bx, dx = q.x_m - p.x_m, dy = q.y_m - p.y_m;
  if (area == 0.0) return {-1.0, -1.0};
  return {(dx * by - dy * bx) / area, (dx * ay - dy * ax) / area};
}

}  // namespace

std::vector<Crossing> find_crossings(const crg::ReferenceLine& line, std::span<const double> z_m) {
  std::vector<Crossing> crossings;
  if (line.size() < 3 || z_m.size() != line.size()) return crossings;
  const auto every = std::max<std::size_t>(1, static_cast<std::size_t>(kPiece_m / line.u_step_m));
  std::vector<std::size_t> nodes;
  for (std::size_t i = 0; i + 1 < line.size(); i += every) nodes.push_back(i);
  nodes.push_back(line.size() - 1);
  const auto at = [&](std::size_t k) {
    return crg::Point2{line.x_m[nodes[k]], line.y_m[nodes[k]]};
  };

  // Pieces by the squares of the plan that they touch; squares as long as the longest piece.
  const std::size_t pieces = nodes.size() - 1;
  double longest_m = 0.0;
  for (std::size_t k = 0; k < pieces; ++k)
    longest_m =
        std::max(longest_m, std::hypot(at(k + 1).x_m - at(k).x_m, at(k + 1).y_m - at(k).y_m));
  if (!(longest_m > 0.0)) return crossings;
  const auto square = [&](double coordinate_m) {
    return static_cast<long>(std::floor(coordinate_m / longest_m));
  };
  std::map<std::pair<long, long>, std::vector<std::size_t>> touching;
  const auto height_at = [&](double node) {
    return z_m[std::min(static_cast<std::size_t>(std::lround(node)), z_m.size() - 1)];
  };
  for (std::size_t k = 0; k < pieces; ++k) {
    const crg::Point2 a = at(k), b = at(k + 1);
    std::vector<std::size_t> near;
    for (long sx = square(std::min(a.x_m, b.x_m)); sx <= square(std::max(a.x_m, b.x_m)); ++sx) {
      for (long sy = square(std::min(a.y_m, b.y_m)); sy <= square(std::max(a.y_m, b.y_m)); ++sy) {
        std::vector<std::size_t>& here = touching[{sx, sy}];
        near.insert(near.end(), here.begin(), here.end());
        here.push_back(k);
      }
    }
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    for (const std::size_t other : near) {
      const bool neighbours = k - other <= 1 || (line.closed && other == 0 && k + 1 == pieces);
      if (neighbours) continue;
      const auto [on_other, on_this] = meeting(at(other), at(other + 1), a, b);
      if (on_other < 0.0 || on_other >= 1.0 || on_this < 0.0 || on_this >= 1.0) continue;
      const auto node = [&](std::size_t piece, double share) {
        return static_cast<double>(nodes[piece]) +
               share * static_cast<double>(nodes[piece + 1] - nodes[piece]);
      };
      const double first = node(other, on_other), second = node(k, on_this);
      crossings.push_back({line.u_begin_m + first * line.u_step_m,
                           line.u_begin_m + second * line.u_step_m,
                           height_at(second) - height_at(first)});
    }
  }
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    return std::tie(a.u_first_m, a.u_second_m) < std::tie(b.u_first_m, b.u_second_m);
  });
  return crossings;
}

bool is_level(const Crossing& crossing) { return std::abs(crossing.height_m) <= kSameLevel_m; }

std::string describe(const Crossing& crossing) {
  const std::string lies = std::isnan(crossing.height_m) ? "meets"
                           : is_level(crossing)
                               ? "lies level with"
                               : fmt::format("lies {:.1f} m {}", std::abs(crossing.height_m),
                                             crossing.height_m > 0.0 ? "below" : "above");
  return fmt::format(
      "the road crosses itself: u = {:.1f} m {} u = {:.1f} m; a point there has two places, a car "
      "finds its own by the way it came",
      crossing.u_first_m, lies, crossing.u_second_m);
}

}  // namespace road
