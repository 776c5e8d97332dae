#include "circuit_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace road {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double middle(const Circuit::Data& data, const std::vector<double>& limit_m, double u_m) {
  const double position = u_m / data.middle_step_m;
  const auto i = std::min(static_cast<std::size_t>(position), limit_m.size() - 1);
  const std::size_t next =
      data.design.closed ? (i + 1) % limit_m.size() : std::min(i + 1, limit_m.size() - 1);
  const double t = position - static_cast<double>(i);
  return (1.0 - t) * limit_m[i] + t * limit_m[next];
}

double kerb_profile(const KerbProfile& profile, double t) {
  const auto above = std::upper_bound(profile.t.begin(), profile.t.end(), t);
  if (above == profile.t.end()) return profile.height.back();
  const auto i = static_cast<std::size_t>(above - profile.t.begin());
  const double share = (t - profile.t[i - 1]) / (profile.t[i] - profile.t[i - 1]);
  return profile.height[i - 1] + share * (profile.height[i] - profile.height[i - 1]);
}

/// 1 in the middle, 0 at distance 1 and beyond.
double bump_window(BumpDesign::Shape shape, double distance) {
  distance = std::abs(distance);
  if (distance >= 1.0) return 0.0;
  if (shape == BumpDesign::Shape::plateau) {
    if (distance <= 0.5) return 1.0;
    distance = 2.0 * (distance - 0.5);
  }
  return 0.5 * (1.0 + std::cos(std::numbers::pi * distance));
}

double outside(double edge_distance_m, double slope, const KerbDesign* kerb, double kerb_height_m) {
  double height = slope * edge_distance_m;
  if (kerb && edge_distance_m < kerb->width_m) {
    height += kerb_height_m * kerb_profile(kerb->profile, edge_distance_m / kerb->width_m);
  }
  return height;
}

}  // namespace

double wrapped(const Circuit::Data& data, double u_m) {
  if (!data.design.closed) return std::clamp(u_m, 0.0, data.length_m);
  const double u = std::fmod(u_m, data.length_m);
  return u < 0.0 ? u + data.length_m : u;
}

ReferencePoint reference(const Circuit::Data& data, double u_m) {
  const double u = wrapped(data, u_m);
  const auto above = std::upper_bound(data.segment_u_m.begin() + 1, data.segment_u_m.end() - 1, u);
  const auto i = static_cast<std::size_t>(above - data.segment_u_m.begin()) - 1;
  const PlanSegment& segment = data.design.plan[i];
  const double s = u - data.segment_u_m[i];
  const PlanPose pose = advance(data.segment_pose[i], segment, s);
  const double rate = (segment.curvature_end_1pm - segment.curvature_begin_1pm) / segment.length_m;
  return {pose.x_m, pose.y_m, pose.heading_rad, segment.curvature_begin_1pm + rate * s};
}

CrossSection section(const Circuit::Data& data, double u_m) {
  const double u = wrapped(data, u_m);
  CrossSection cross{};
  cross.z_m = data.elevation.at(u);
  cross.banking = data.banking.at(u);
  cross.road_left_m = data.width_left.at(u);
  cross.road_right_m = -data.width_right.at(u);
  cross.outer_left_m = cross.road_left_m + data.runoff_left.at(u);
  cross.outer_right_m = cross.road_right_m - data.runoff_right.at(u);
  const double left = middle(data, data.middle_left_m, u) - kMiddleMarginM;
  const double right = -(middle(data, data.middle_right_m, u) - kMiddleMarginM);
  cross.cut_left = left < cross.outer_left_m;
  cross.cut_right = right > cross.outer_right_m;
  if (cross.cut_left) cross.outer_left_m = left;
  if (cross.cut_right) cross.outer_right_m = right;
  return cross;
}

CircuitRow row_at(const Circuit::Data& data, double u_m) {
  const double u = wrapped(data, u_m);
  CircuitRow row{};
  row.cross = section(data, u);
  row.slope_left = data.slope_left.at(u);
  row.slope_right = data.slope_right.at(u);
  for (const KerbDesign& kerb : data.design.kerbs) {
    if (u < kerb.u_begin_m || u > kerb.u_end_m) continue;
    const double inside = std::min(u - kerb.u_begin_m, kerb.u_end_m - u);
    const double taper = kerb.taper_m > 0.0 ? std::min(1.0, inside / kerb.taper_m) : 1.0;
    (kerb.side == Side::left ? row.kerb_left : row.kerb_right) = &kerb;
    (kerb.side == Side::left ? row.kerb_left_height_m : row.kerb_right_height_m) =
        taper * kerb.height_m;
  }
  for (const BumpDesign& bump : data.design.bumps) {
    double distance = u - bump.u_m;
    if (data.design.closed) distance = std::remainder(distance, data.length_m);
    const double share = bump_window(bump.shape, distance / (0.5 * bump.length_m));
    if (share > 0.0) row.bumps.emplace_back(&bump, share * bump.height_m);
  }
  return row;
}

double smooth_height(const CircuitRow& row, double v) {
  constexpr double kBorderM = 1e-9;
  const CrossSection& cross = row.cross;
  if (!(v >= cross.outer_right_m - kBorderM) || !(v <= cross.outer_left_m + kBorderM)) return kNaN;
  double z = cross.z_m + cross.banking * v;
  if (v > cross.road_left_m) {
    z += outside(v - cross.road_left_m, row.slope_left, row.kerb_left, row.kerb_left_height_m);
  } else if (v < cross.road_right_m) {
    z += outside(cross.road_right_m - v, row.slope_right, row.kerb_right, row.kerb_right_height_m);
  }
  for (const auto& [bump, height] : row.bumps) {
    z += bump->width_m > 0.0
             ? height * bump_window(bump->shape, (v - bump->v_m) / (0.5 * bump->width_m))
             : height;
  }
  return z;
}

ReferencePoint reference_at(const Circuit& circuit, double u_m) {
  return reference(circuit.data(), u_m);
}

CrossSection section_at(const Circuit& circuit, double u_m) { return section(circuit.data(), u_m); }

crg::Point2 position_at(const Circuit& circuit, double u_m, double v_m) {
  const ReferencePoint point = reference(circuit.data(), u_m);
  return {point.x_m - v_m * std::sin(point.heading_rad),
          point.y_m + v_m * std::cos(point.heading_rad)};
}

double true_height(const Circuit& circuit, double u_m, double v_m) {
  const Circuit::Data& data = circuit.data();
  const double u = wrapped(data, u_m);
  const double smooth = smooth_height(row_at(data, u), v_m);
  return std::isnan(smooth) ? smooth : smooth + data.roughness.height_m(u, v_m);
}

std::optional<SurfaceClass> true_class(const Circuit& circuit, double u_m, double v_m) {
  const CircuitRow row = row_at(circuit.data(), u_m);
  const CrossSection& cross = row.cross;
  if (!(v_m >= cross.outer_right_m) || !(v_m <= cross.outer_left_m)) return std::nullopt;
  if (v_m <= cross.road_left_m && v_m >= cross.road_right_m) return SurfaceClass::road;
  const bool left = v_m > 0.0;
  const KerbDesign* kerb = left ? row.kerb_left : row.kerb_right;
  const double distance = left ? v_m - cross.road_left_m : cross.road_right_m - v_m;
  return kerb && distance <= kerb->width_m ? SurfaceClass::kerb : SurfaceClass::runoff;
}

}  // namespace road
