// Whether a path lies beside where it was driven, by the way that it leaves to the road's edges.
#pragma once

#include <optional>
#include <vector>

namespace explain {

/// One step of a path: how far it is from both edges of the road, and the way to the left one.
struct BetweenEdges {
  double left_m = 0.0, right_m = 0.0;  ///< below 0 beyond the edge
  double to_left_x = 0.0, to_left_y = 0.0;
};

/// What a path is moved by, and how near it comes to an edge.
struct PathShift {
  double x_m = 0.0, y_m = 0.0;
  double least_before_m = 0.0, least_after_m = 0.0;
};

/// The shift by metres that takes the path of whole laps away from edges in every direction, where
/// one does. None for drivers who cut corners, keep to one side or leave the road: no shift mends
/// that all round.
std::optional<PathShift> shift_onto_road(const std::vector<BetweenEdges>& path);

}  // namespace explain
