#include "changed_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "cloud/road_frame.h"
#include "report/change_map.h"

namespace cloud {
namespace {

constexpr double kSquare_m = 0.5;
constexpr double kFaint_m = 0.02, kStrong_m = 0.1;  // what has full colour at least and at most

bool is_by_points(float source) {
  return source == static_cast<float>(NodeSource::lidar) ||
         source == static_cast<float>(NodeSource::interpolated);
}

/// Sum of the differences in a square, and how many.
using Squares = std::map<std::pair<double, double>, std::pair<double, double>>;

Squares squares_of(const RoadFrame& frame, const MapResult& newer, const OlderRoad& older,
                   double square_m) {
  Squares out;
  const std::size_t columns = frame.columns();
  for (std::size_t i = 0; i < frame.rows(); ++i)
    for (std::size_t j = 0; j < columns; ++j) {
      const std::size_t k = i * columns + j;
      if (!is_by_points(newer.source.z_m[k]) || !is_by_points(older.source.z_m[k])) continue;
      const Eigen::Vector2d at = frame.node_position(i, frame.v_m()[j]);
      auto& [sum, count] = out[{std::floor(at.y() / square_m), std::floor(at.x() / square_m)}];
      sum += static_cast<double>(newer.grid.z_m[k]) - static_cast<double>(older.grid.z_m[k]);
      count += 1.0;
    }
  return out;
}

}  // namespace

std::string changed_map_png(const crg::Crg& base, const MapResult& newer, const OlderRoad& older) {
  const RoadFrame frame(base);
  const double square_m = std::max(kSquare_m, 2.0 * frame.u_step_m());
  std::vector<report::ChangeSquare> squares;
  for (const auto& [key, sum] : squares_of(frame, newer, older, square_m))
    squares.push_back(
        {(key.second + 0.5) * square_m, (key.first + 0.5) * square_m, sum.first / sum.second});
  if (squares.empty()) return "";
  std::vector<report::ChangeMark> marks;
  double most_m = kFaint_m;
  for (const ChangedPlace& place : newer.report.changed) {
    const double rows =
        (0.5 * (place.u_begin_m + place.u_end_m) - frame.u_begin_m()) / frame.u_step_m();
    const auto row = static_cast<std::size_t>(
        std::clamp(std::round(rows), 0.0, static_cast<double>(frame.rows() - 1)));
    const Eigen::Vector2d at = frame.node_position(row, 0.5 * (place.v_begin_m + place.v_end_m));
    marks.push_back({at.x(), at.y(), std::sqrt(place.area_m2 / std::numbers::pi)});
    most_m = std::max(most_m, std::abs(place.change_m));
  }
  return report::change_map_png(
      squares, square_m, marks, std::min(most_m, kStrong_m),
      fmt::format("Change of height between passes, new less old: {} places", marks.size()));
}

}  // namespace cloud
