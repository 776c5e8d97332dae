// The heights of a mesh or of another road as a reference to compare with.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "inspect/compare.h"
#include "nan.h"

namespace road {
namespace {

constexpr double kUpright = 0.1;  // on a wall a ray meets any height

}  // namespace

ReferenceHeights reference_of(const RaySurface& mesh, const RotoTranslation& T_global_mesh,
                              double reach_m) {
  const double cosine = std::cos(T_global_mesh.yaw_rad), sine = std::sin(T_global_mesh.yaw_rad);
  const Eigen::Vector3d shift = T_global_mesh.translation_m;
  return [&mesh, cosine, sine, shift, reach_m](std::span<const crg::Point2> points,
                                               std::span<const double> z_near_m,
                                               std::span<double> z_out_m) {
    const Eigen::Vector3d& origin = mesh.origin_m();
    RayPacket16 packet;
    packet.max_depth_m = static_cast<float>(2.0 * reach_m);
    std::array<double, 16> x{}, y{};
    for (std::size_t first = 0; first < points.size(); first += 16) {
      const std::size_t count = std::min<std::size_t>(16, points.size() - first);
      for (std::size_t k = 0; k < 16; ++k) {
        const std::size_t i = first + std::min(k, count - 1);
        const double dx = points[i].x_m - shift.x(), dy = points[i].y_m - shift.y();
        x[k] = cosine * dx + sine * dy;
        y[k] = -sine * dx + cosine * dy;
        packet.x_m[k] = static_cast<float>(x[k] - origin.x());
        packet.y_m[k] = static_cast<float>(y[k] - origin.y());
        const double top = z_near_m[i] - shift.z() - origin.z() + reach_m;
        packet.z_top_m[k] = std::isnan(top) ? 0.0f : static_cast<float>(top);
        packet.active[k] = k < count && !std::isnan(top) ? -1 : 0;
      }
      mesh.cast_down(packet);
      for (std::size_t k = 0; k < count; ++k) {
        const double near = z_near_m[first + k] - shift.z();
        double z = packet.active[k] == 0 ? kNan : static_cast<double>(packet.z_m[k]) + origin.z();
        // The first hit from above may be another layer, and a ray through an edge may miss: look
        // again.
        if (packet.active[k] != 0 && !(std::abs(z - near) < 0.005)) {
          const auto hit = mesh.nearest_hit(x[k], y[k], near, reach_m);
          z = hit && hit->upright > kUpright ? hit->z_m : kNan;
        }
        z_out_m[first + k] = z + shift.z();
      }
    }
  };
}

ReferenceHeights reference_of(const crg::Surface& surface, double reach_m) {
  return [&surface, reach_m](std::span<const crg::Point2> points, std::span<const double> z_near_m,
                             std::span<double> z_out_m) {
    const crg::Grid& grid = surface.grid();
    const crg::ReferenceLine& line = surface.reference_line();
    const double u_end_m = line.u_begin_m + static_cast<double>(line.size() - 1) * line.u_step_m;
    constexpr double kEdge_m =
        1e-6;  // nodes on the border of both files must not fall off by rounding
    crg::Cursor cursor;
    for (std::size_t i = 0; i < points.size(); ++i) {
      z_out_m[i] = kNan;
      if (std::isnan(z_near_m[i])) continue;
      const crg::UV uv = surface.uv_of_xy(points[i].x_m, points[i].y_m, cursor);
      if (!(uv.u_m >= line.u_begin_m - kEdge_m && uv.u_m <= u_end_m + kEdge_m &&
            uv.v_m >= grid.v_m.front() - kEdge_m && uv.v_m <= grid.v_m.back() + kEdge_m))
        continue;
      const double z = surface.z_at_uv(std::clamp(uv.u_m, line.u_begin_m, u_end_m),
                                       std::clamp(uv.v_m, grid.v_m.front(), grid.v_m.back()));
      if (std::abs(z - z_near_m[i]) <= reach_m) z_out_m[i] = z;
    }
  };
}

}  // namespace road
