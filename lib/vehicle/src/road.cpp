#include "vehicle/road.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vehicle {
namespace {

/// Farther than this from the wheel, the answer may be the other level of a bridge.
constexpr double kOtherLevel_m = 1.5;

}  // namespace

RoadPoint Road::at(double x_m, double y_m, double z_near_m, std::size_t wheel,
                   RoadCursors& cursors) const noexcept {
  RoadPoint out;
  if (surface_ == nullptr) {
    out.z_m = slope_x_ * x_m + slope_y_ * y_m;
    out.dzdx = slope_x_;
    out.dzdy = slope_y_;
    out.u_m = x_m;
    out.v_m = y_m;
    return out;
  }
  crg::Sample sample = surface_->at_xy(x_m, y_m, cursors.wheel[wheel]);
  if (std::abs(sample.z_m - z_near_m) > kOtherLevel_m || (!sample.valid && std::isfinite(z_near_m)))
    sample = other_leg(x_m, y_m, z_near_m, sample);
  if (!sample.valid) return nearest_valid(sample);
  out.z_m = sample.z_m;
  out.dzdx = sample.dzdx;
  out.dzdy = sample.dzdy;
  out.u_m = sample.u_m;
  out.v_m = sample.v_m;
  // A closed road has no end: the millimetre between its last row and its first is road.
  const auto& v_m = surface_->file().grid.v_m;
  out.on_road = sample.inside || (surface_->reference_line().closed && sample.v_m >= v_m.front() &&
                                  sample.v_m <= v_m.back());
  out.friction = sample.friction;
  return out;
}

crg::Sample Road::other_leg(double x_m, double y_m, double z_near_m,
                            const crg::Sample& first) const noexcept {
  const crg::ReferenceLine& line = surface_->reference_line();
  const auto& v_m = surface_->file().grid.v_m;
  if (v_m.size() < 2) return first;
  const double reach = std::max(std::abs(v_m.front()), std::abs(v_m.back()));
  constexpr double kStride_m = 4.0;
  const auto stride = static_cast<std::size_t>(std::max(1.0, kStride_m / line.u_step_m));
  crg::Sample best = first;
  double distance =
      first.valid ? std::abs(first.z_m - z_near_m) : std::numeric_limits<double>::infinity();
  double last_u = -1e300;
  for (std::size_t i = 0; i < line.size(); i += stride) {
    if (std::hypot(x_m - line.x_m[i], y_m - line.y_m[i]) > reach + kStride_m) continue;
    // The foot of the point on this leg, by steps along the line.
    double u = line.u_begin_m + static_cast<double>(i) * line.u_step_m, v = 0.0;
    for (int k = 0; k < 30; ++k) {
      const crg::Point2 base = surface_->xy_of_uv(u, 0.0), left = surface_->xy_of_uv(u, 1.0);
      const double nx = left.x_m - base.x_m, ny = left.y_m - base.y_m;
      const double dx = x_m - base.x_m, dy = y_m - base.y_m;
      v = dx * nx + dy * ny;
      const double along = dx * ny - dy * nx;
      u += along;
      if (std::abs(along) < 1e-10) break;
    }
    if (std::abs(u - last_u) < 1e-6) continue;
    last_u = u;
    const crg::Point2 back = surface_->xy_of_uv(u, v);
    if (!(std::hypot(back.x_m - x_m, back.y_m - y_m) < 1e-3)) continue;
    if (v < v_m.front() || v > v_m.back()) continue;
    const crg::Sample sample = surface_->at_uv(u, v);
    if (!sample.valid || !sample.inside) continue;
    const double away = std::abs(sample.z_m - z_near_m);
    if (away < distance) {
      distance = away;
      best = sample;
    }
  }
  return best;
}

RoadPoint Road::nearest_valid(const crg::Sample& hole) const noexcept {
  RoadPoint out;
  out.on_road = false;
  out.u_m = hole.u_m;
  out.v_m = hole.v_m;
  out.z_m = std::numeric_limits<double>::quiet_NaN();
  const auto& v_m = surface_->file().grid.v_m;
  if (v_m.size() < 2 || !std::isfinite(hole.u_m)) return out;
  const double step = (v_m.back() - v_m.front()) / static_cast<double>(v_m.size() - 1);
  const double start = std::clamp(hole.v_m, v_m.front(), v_m.back());
  for (std::size_t i = 0; i < v_m.size(); ++i) {
    for (const double side : {-1.0, 1.0}) {
      const double v = start + side * static_cast<double>(i) * step;
      const double z = surface_->z_at_uv(hole.u_m, v);
      if (std::isfinite(z)) {
        out.z_m = z;
        return out;
      }
    }
  }
  return out;
}

}  // namespace vehicle
