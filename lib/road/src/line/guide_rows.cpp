#include "guide_rows.h"

#include <cmath>
#include <cstddef>
#include <limits>

#include "base/parallel.h"
#include "guide_curve.h"
#include "guide_layers.h"
#include "settle_rows.h"
#include "stations.h"

namespace road {
namespace {

using Eigen::Vector2d;

constexpr double kLayer_m = 1.0;
constexpr double kPaintAcross_m = 1.0;  // painted lines, cracks
constexpr double kStep_m = 0.15;        // up or down between two rays, besides the slope
constexpr double kSteepestAcross = 0.6, kCrease = 0.35;

/// From `from_m` (offset) outwards: how far the road goes on.
struct Side {
  double offset_m = 0.0;
  bool ends = false;
};
Side road_side(const GuideRow& row, const GuideRows& all, double scale, const RaySurface& surface,
               const LooksLikeRoad& looks_like_road, double from_m, double from_z_m, double sign) {
  const Vector2d normal = left_of(row.heading);
  Side side{from_m, false};
  double z_m = from_z_m, slope = 0.0;
  bool has_slope = false;
  for (double offset_m = from_m + sign * all.across_m; std::abs(offset_m) <= all.reach_m;
       offset_m += sign * all.across_m) {
    const double out_m = std::abs(offset_m - side.offset_m);
    const Vector2d p = row.at_m + offset_m * normal;
    const auto hit = surface.nearest_hit(p.x(), p.y(), z_m + slope * out_m, kLayer_m * scale);
    bool goes_on = hit && looks_like_road(hit->triangle);
    if (goes_on) {
      const double steep = (hit->z_m - z_m) / out_m;
      const double step_m = std::abs(hit->z_m - z_m - slope * out_m);
      const bool steps = step_m > kStep_m * scale + (has_slope ? kCrease : kSteepestAcross) * out_m;
      goes_on = !steps && std::abs(steep) < kSteepestAcross;
      if (!goes_on) {
        side.ends = true;
        return side;
      }
      slope = has_slope ? 0.7 * slope + 0.3 * steep : steep;
      has_slope = true;
      side.offset_m = offset_m;
      z_m = hit->z_m;
    } else if (out_m > kPaintAcross_m * scale) {
      side.ends = true;
      return side;
    }
  }
  return side;
}

/// Sides of one row, from the place nearest to the guide that is road; none there: no surface.
void measure(GuideRow& row, const GuideRows& all, double scale, const RaySurface& surface,
             const LooksLikeRoad& looks_like_road) {
  if (!row.has_surface) return;
  const Vector2d normal = left_of(row.heading);
  const int most = static_cast<int>(kBeside * all.reach_m / all.across_m);
  for (int k = 0; k <= 2 * most; ++k) {
    const int steps = (k + 1) / 2;  // 0, -1, 1, -2, 2, ...
    const double offset_m = all.across_m * steps * (k % 2 == 0 ? 1.0 : -1.0);
    const Vector2d p = row.at_m + offset_m * normal;
    const auto hit = surface.nearest_hit(p.x(), p.y(), row.z_m, kLayer_m * scale);
    if (!hit || !looks_like_road(hit->triangle)) continue;
    const Side left = road_side(row, all, scale, surface, looks_like_road, offset_m, hit->z_m, 1.0);
    const Side right =
        road_side(row, all, scale, surface, looks_like_road, offset_m, hit->z_m, -1.0);
    row.left_m = left.offset_m, row.ends_left = left.ends;
    row.right_m = right.offset_m, row.ends_right = right.ends;
    return;
  }
  row.has_surface = false;
}

}  // namespace

GuideRows rows_along(const Guide& guide, const RaySurface& surface,
                     const LooksLikeRoad& looks_like_road) {
  GuideRows all = empty_rows(guide);
  const double scale = all.reach_m / kUsualReach_m;
  const std::size_t n = all.rows.size();
  std::vector<std::vector<Layer>> layers(n);
  base::parallel_for(n, 16, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      layers[i] = layers_at(all.rows[i], all, scale, surface, looks_like_road);
  });
  weigh_heights(all, scale, layers);
  std::vector<double> z_m = best_layers(layers, all.step_m, scale);
  for (std::size_t i = 0; i < n; ++i) all.rows[i].has_surface = std::isfinite(z_m[i]);
  fill_between(z_m, guide.closed);
  base::parallel_for(n, 16, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      all.rows[i].z_m = z_m[i];
      measure(all.rows[i], all, scale, surface, looks_like_road);
    }
  });
  for (std::size_t i = 0; i < n; ++i)
    if (!all.rows[i].has_surface) z_m[i] = std::numeric_limits<double>::quiet_NaN();
  fill_between(z_m, guide.closed);
  for (std::size_t i = 0; i < n; ++i) all.rows[i].z_m = z_m[i];
  settle(all, scale);
  return all;
}

void set_width(GuideRows& all, double width_m) {
  all.usual_half_m = 0.5 * width_m;
  for (GuideRow& row : all.rows) {
    if (row.is_usual && std::abs(row.half_width_m - 0.5 * width_m) < 0.125 * width_m) continue;
    row.is_usual = false;
    row.half_width_m = 0.5 * width_m;
    row.middle_m = 0.0;
  }
}

}  // namespace road
