// The plan of a synthetic circuit: where its curve runs, and that it closes. Private to the
// circuit.
#pragma once

#include <numbers>

#include "circuit/circuit.h"

namespace road {

constexpr double kDegree = std::numbers::pi / 180.0;  ///< in radians

/// A place on the reference curve; the heading is not wrapped.
struct PlanPose {
  double x_m, y_m, heading_rad;
};

/// Pose after `s_m` metres of a segment that begins at `start`.
PlanPose advance(const PlanPose& start, const PlanSegment& segment, double s_m);

/// Throws Error where a segment has no length, turns too far, or curvature jumps behind it.
void check_plan(const CircuitDesign& design);

/// Heading must come round to a multiple of 360 degrees; two straights then close the position,
/// which is linear in their lengths. Throws Error where they cannot.
void close_plan(CircuitDesign& design);

}  // namespace road
