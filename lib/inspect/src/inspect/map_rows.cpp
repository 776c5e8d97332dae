#include "map_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "nan.h"

namespace road {
RowPlace place_of(const HeightMap& map, double u_m) {
  const double at = std::clamp((u_m - map.line.u_begin_m) / map.line.u_step_m, 0.0,
                               static_cast<double>(map.rows() - 1));
  const auto row = std::min(map.rows() - 2, static_cast<std::size_t>(at));
  return {row, at - static_cast<double>(row)};
}

RowLine line_of(const HeightMap& map, const RowPlace& place) {
  RowLine line{};
  const auto mix = [&](double v_m) {
    const crg::Point2 a = crg::node_position(map.line, place.row, v_m),
                      b = crg::node_position(map.line, place.row + 1, v_m);
    return crg::Point2{a.x_m + place.share * (b.x_m - a.x_m),
                       a.y_m + place.share * (b.y_m - a.y_m)};
  };
  line.middle = mix(0.0);
  const crg::Point2 one = mix(1.0);
  line.per_metre = {one.x_m - line.middle.x_m, one.y_m - line.middle.y_m};
  return line;
}

double height_at(const HeightMap& map, const RowPlace& place, double v_m) {
  if (v_m < map.v_m.front() || v_m > map.v_m.back()) return kNan;
  const auto j = static_cast<std::size_t>(
      std::upper_bound(map.v_m.begin() + 1, map.v_m.end() - 1, v_m) - map.v_m.begin());
  const double t = (v_m - map.v_m[j - 1]) / (map.v_m[j] - map.v_m[j - 1]);
  const auto across = [&](std::size_t row) {
    const double a = map.at(row, j - 1), b = map.at(row, j);
    return t == 0.0 ? a : t == 1.0 ? b : a + t * (b - a);
  };
  const double low = across(place.row);
  if (place.share == 0.0) return map.z_base_m + low;
  const double high = across(place.row + 1);
  return map.z_base_m + (place.share == 1.0 ? high : low + place.share * (high - low));
}

CrossCut cut(const HeightMap& map, const ReferenceHeights& reference, double u_m, double v_m,
             double v_low_m, double v_high_m) {
  CrossCut result;
  result.u_m = u_m;
  result.v_m = v_m;
  const RowPlace place = place_of(map, u_m);
  const RowLine line = line_of(map, place);
  constexpr double kStep_m = 0.05;
  v_low_m = std::max(v_low_m, map.v_m.front());
  v_high_m = std::min(v_high_m, map.v_m.back());
  const auto count = static_cast<std::size_t>((v_high_m - v_low_m) / kStep_m) + 1;
  std::vector<crg::Point2> points;
  for (std::size_t k = 0; k < count; ++k) {
    const double v = v_low_m + static_cast<double>(k) * kStep_m;
    result.at_v_m.push_back(v);
    result.file_z_m.push_back(height_at(map, place, v));
    points.push_back(line.at(v));
  }
  result.reference_z_m.assign(count, kNan);
  reference(points, result.file_z_m, result.reference_z_m);
  return result;
}

}  // namespace road
