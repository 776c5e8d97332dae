// The surface of a synthetic circuit, from its splines and lists. Private to the circuit.
#pragma once

#include <utility>
#include <vector>

#include "circuit/circuit.h"
#include "plan_view.h"
#include "spline.h"

namespace road {

struct Circuit::Data {
  CircuitDesign design;
  std::vector<double> segment_u_m;     // begin of each segment, then the length
  std::vector<PlanPose> segment_pose;  // at each begin
  double length_m = 0.0;
  double closing_error_m = 0.0;
  Spline width_left, width_right, elevation, banking;
  Spline runoff_left, runoff_right, slope_left, slope_right;
  Roughness roughness;
  // Distance to the middle to the nearest other part of the curve, at u = i * middle_step_m.
  double middle_step_m = 0.0;
  std::vector<double> middle_left_m, middle_right_m;
  // Curve points at u = i * middle_step_m, for the inverse.
  std::vector<crg::Point2> curve;
  double reach_m = 0.0;  // no surface further than this from the curve
};

// Free strip on each side of the middle between two legs, and around the centre of a hairpin.
inline constexpr double kMiddleMarginM = 0.5;

/// u within the circuit: wrapped where it is closed, else clamped.
double wrapped(const Circuit::Data& data, double u_m);

ReferencePoint reference(const Circuit::Data& data, double u_m);
CrossSection section(const Circuit::Data& data, double u_m);

/// Everything of the surface that depends on u only, so that a row of nodes shares it.
struct CircuitRow {
  CrossSection cross;
  double slope_left, slope_right;
  const KerbDesign* kerb_left = nullptr;
  const KerbDesign* kerb_right = nullptr;
  double kerb_left_height_m = 0.0, kerb_right_height_m = 0.0;  // tapered
  std::vector<std::pair<const BumpDesign*, double>> bumps;     // height at this u
};

CircuitRow row_at(const Circuit::Data& data, double u_m);

/// All but the roughness. v on the border counts as inside.
double smooth_height(const CircuitRow& row, double v);

}  // namespace road
