#include "circuit_legs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "mesh/error.h"

namespace road {
namespace {

// Legs whose heights differ by more than this do not limit each other: one is a bridge.
constexpr double kLayerHeightM = 4.0;

/// Radius of the circle that touches the curve at `at` on the given side and passes through
/// `other`: its centre is the middle between the two.
double middle_radius(const crg::Point2& at, double normal_x, double normal_y,
                     const crg::Point2& other) {
  const double dx = other.x_m - at.x_m;
  const double dy = other.y_m - at.y_m;
  const double towards = dx * normal_x + dy * normal_y;
  return towards > 0.0 ? (dx * dx + dy * dy) / (2.0 * towards)
                       : std::numeric_limits<double>::infinity();
}

}  // namespace

void find_middles(Circuit::Data& data) {
  const auto count = static_cast<std::size_t>(std::ceil(data.length_m / kMiddleStepM)) +
                     (data.design.closed ? 0 : 1);
  const std::size_t intervals = data.design.closed ? count : count - 1;
  data.middle_step_m = data.length_m / static_cast<double>(intervals);
  data.reach_m = std::max(data.width_left.largest() + data.runoff_left.largest(),
                          data.width_right.largest() + data.runoff_right.largest());
  std::vector<ReferencePoint> points(count);
  std::vector<double> z(count);
  data.curve.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double u = static_cast<double>(i) * data.middle_step_m;
    points[i] = reference(data, u);
    z[i] = data.elevation.at(u);
    data.curve[i] = {points[i].x_m, points[i].y_m};
  }
  const double far = 2.0 * (data.reach_m + kMiddleMarginM);
  data.middle_left_m.assign(count, far);
  data.middle_right_m.assign(count, far);
  for (std::size_t i = 0; i < count; ++i) {
    const double nx = -std::sin(points[i].heading_rad);
    const double ny = std::cos(points[i].heading_rad);
    const double bend = points[i].curvature_1pm;
    double& left = data.middle_left_m[i];
    double& right = data.middle_right_m[i];
    if (bend > 0.0) left = std::min(left, 1.0 / bend);
    if (bend < 0.0) right = std::min(right, -1.0 / bend);
    for (std::size_t j = 0; j < count;) {
      const double dx = data.curve[j].x_m - data.curve[i].x_m;
      const double dy = data.curve[j].y_m - data.curve[i].y_m;
      const double distance = std::hypot(dx, dy);
      if (distance > far) {  // the curve cannot come back within `far` sooner
        j += std::max<std::size_t>(1,
                                   static_cast<std::size_t>((distance - far) / data.middle_step_m));
        continue;
      }
      if (j != i && std::abs(z[j] - z[i]) < kLayerHeightM) {
        left = std::min(left, middle_radius(data.curve[i], nx, ny, data.curve[j]));
        right = std::min(right, middle_radius(data.curve[i], -nx, -ny, data.curve[j]));
      }
      ++j;
    }
    const double u = static_cast<double>(i) * data.middle_step_m;
    for (const auto& [limit, edge, side] : {std::tuple{left, data.width_left.at(u), "left"},
                                            std::tuple{right, data.width_right.at(u), "right"}}) {
      if (edge + kMiddleMarginM >= limit) {
        throw Error(
            fmt::format("{}: at u = {:.1f} m the road is {:.2f} m wide on the {} but meets "
                        "another part of itself after {:.2f} m; widen the bend or move the legs "
                        "apart (a bridge needs {} m of height)",
                        data.design.name, u, edge, side, limit, kLayerHeightM));
      }
    }
  }
}

}  // namespace road
