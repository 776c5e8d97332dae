// Which place of one edge lies beside which of the other. Private to the edges stage.
#pragma once

#include <vector>

#include "edge_curve.h"
#include "road/centreline.h"

namespace road {

/// Along the line between the edges, in metres.
inline constexpr double kStationStep_m = 1.0;

/// A line from one edge to the other, by length along both.
struct Rung {
  double left_s_m, right_s_m;
};

/// How RIGHT lies along LEFT: which way its rows run, on which side, and where it begins.
struct Relation {
  int forward = 0, backward = 0, on_right = 0, on_left = 0;
  double right_s_at_start_m = 0.0;
};

Relation relate(const EdgeCurve& left, const EdgeCurve& right);

/// Rungs from the start on, each time forward on the side that gives the shorter rung: works
/// without any correspondence of points, through hairpins and figure-eights, as long as the edges
/// run beside each other.
std::vector<Rung> climb(const EdgeCurve& left, const EdgeCurve& right, double right_s_m);

/// Stations halfway up the rungs: a first guess of the line.
Centreline along(const EdgeCurve& left, const EdgeCurve& right, const std::vector<Rung>& rungs);

}  // namespace road
