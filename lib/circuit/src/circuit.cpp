#include "circuit/circuit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "check_design.h"
#include "circuit_legs.h"
#include "circuit_surface.h"
#include "mesh/error.h"

namespace road {
namespace {

// Beyond, tables of half a metre take hours; no track is such.
constexpr double kLongestM = 1e5;

void check_room_of_kerbs(const Circuit::Data& data) {
  for (std::size_t i = 0; i < data.design.kerbs.size(); ++i) {
    const KerbDesign& kerb = data.design.kerbs[i];
    const auto checks = static_cast<int>((kerb.u_end_m - kerb.u_begin_m) / kMiddleStepM);
    for (int k = 0; k <= checks; ++k) {
      const double at = kerb.u_begin_m + k * kMiddleStepM;
      const CrossSection cross = section(data, at);
      const double room = kerb.side == Side::left ? cross.outer_left_m - cross.road_left_m
                                                  : cross.road_right_m - cross.outer_right_m;
      if (kerb.width_m > room - 0.05) {
        throw Error(
            fmt::format("{}: kerb {} is {} m wide but the run-off at u = {:.1f} m only {:.2f} m; "
                        "leave 0.05 m",
                        data.design.name, i, kerb.width_m, at, room));
      }
    }
  }
}

}  // namespace

Circuit::Circuit(CircuitDesign design) {
  auto data = std::make_shared<Data>();
  check_plan(design);
  close_plan(design);
  PlanPose pose{design.start_x_m, design.start_y_m, design.start_heading_rad};
  double u = 0.0;
  for (const PlanSegment& segment : design.plan) {
    data->segment_u_m.push_back(u);
    data->segment_pose.push_back(pose);
    pose = advance(pose, segment, segment.length_m);
    u += segment.length_m;
  }
  data->segment_u_m.push_back(u);
  data->length_m = u;
  if (u > kLongestM) {
    throw Error(fmt::format("{}: the plan is {:.0f} m long; at most {:.0f} m wanted", design.name,
                            u, kLongestM));
  }
  if (design.closed) {
    data->closing_error_m = std::hypot(pose.x_m - design.start_x_m, pose.y_m - design.start_y_m);
  }

  const double period = design.closed ? u : 0.0;
  check_design(design, u);
  data->width_left = Spline::monotone(design.width_left_m, period);
  data->width_right = Spline::monotone(design.width_right_m, period);
  data->elevation = Spline::smooth(design.elevation_m, period);
  data->banking = Spline::monotone(design.banking, period);
  data->runoff_left = Spline::monotone(design.runoff_left_m, period);
  data->runoff_right = Spline::monotone(design.runoff_right_m, period);
  data->slope_left = Spline::monotone(design.runoff_slope_left, period);
  data->slope_right = Spline::monotone(design.runoff_slope_right, period);
  if (design.roughness) data->roughness = Roughness(*design.roughness, u);
  data->design = std::move(design);
  find_middles(*data);
  check_room_of_kerbs(*data);
  data_ = std::move(data);
}

const CircuitDesign& Circuit::design() const noexcept { return data_->design; }
double Circuit::length_m() const noexcept { return data_->length_m; }
double Circuit::closing_error_m() const noexcept { return data_->closing_error_m; }

std::vector<CircuitUV> uv_of_position(const Circuit& circuit, double x_m, double y_m) {
  const Circuit::Data& data = circuit.data();
  const bool closed = data.design.closed;
  const std::size_t count = data.curve.size();
  const double near = data.reach_m + data.middle_step_m;
  // The foot points are the zeros of (point - curve) . tangent that fall with u.
  const auto along = [&](double u) {
    const ReferencePoint point = reference(data, u);
    return (x_m - point.x_m) * std::cos(point.heading_rad) +
           (y_m - point.y_m) * std::sin(point.heading_rad);
  };
  std::vector<CircuitUV> found;
  for (std::size_t i = 0; i < (closed ? count : count - 1);) {
    const double distance = std::hypot(x_m - data.curve[i].x_m, y_m - data.curve[i].y_m);
    if (distance > near) {
      i += std::max<std::size_t>(1,
                                 static_cast<std::size_t>((distance - near) / data.middle_step_m));
      continue;
    }
    double low = static_cast<double>(i) * data.middle_step_m;
    double high = std::min(static_cast<double>(i + 1) * data.middle_step_m, data.length_m);
    ++i;
    double at_low = along(low);
    double at_high = along(high);
    if (!(at_low >= 0.0) || !(at_high < 0.0 || (at_high == 0.0 && !closed && i + 1 == count)))
      continue;
    double u = low;
    for (int step = 0; step < 100 && high - low > 1e-12 * (1.0 + data.length_m); ++step) {
      // Regula falsi (Illinois) with bisection every third step.
      u = step % 3 == 2 ? 0.5 * (low + high) : low + (high - low) * at_low / (at_low - at_high);
      const double at = along(u);
      if (at == 0.0) break;
      if (at > 0.0) {
        low = u, at_low = at;
      } else {
        high = u, at_high = at;
      }
    }
    const ReferencePoint foot = reference(data, u);
    const double v = -(x_m - foot.x_m) * std::sin(foot.heading_rad) +
                     (y_m - foot.y_m) * std::cos(foot.heading_rad);
    const CrossSection cross = section(data, u);
    if (v >= cross.outer_right_m - 1e-9 && v <= cross.outer_left_m + 1e-9) found.push_back({u, v});
  }
  return found;
}

}  // namespace road
