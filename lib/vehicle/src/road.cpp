#include "vehicle/road.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vehicle {

RoadPoint Road::at(double x_m, double y_m, std::size_t wheel, RoadCursors& cursors) const noexcept {
  RoadPoint out;
  if (surface_ == nullptr) {
    out.z_m = slope_x_ * x_m + slope_y_ * y_m;
    out.dzdx = slope_x_;
    out.dzdy = slope_y_;
    out.u_m = x_m;
    out.v_m = y_m;
    return out;
  }
  const crg::Sample sample = surface_->at_xy(x_m, y_m, cursors.height[wheel]);
  if (!sample.valid) {
    out = nearest_valid(sample);
  } else {
    out.z_m = sample.z_m;
    out.dzdx = sample.dzdx;
    out.dzdy = sample.dzdy;
    out.u_m = sample.u_m;
    out.v_m = sample.v_m;
    out.on_road = sample.inside;
  }
  if (friction_ != nullptr) {
    const crg::Sample grip = friction_->at_xy(x_m, y_m, cursors.friction[wheel]);
    if (grip.valid) out.friction = grip.z_m;
  }
  return out;
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
