// Blades of grass are met before the ground they stand on: their points hang over the kerb and the
// asphalt in front of them.
#pragma once

#include <cstdint>
#include <vector>

#include "cloud/road_frame.h"

namespace cloud {

/// A point of a section: along and across the road from a place of its cell's row and column, and
/// over the base.
struct EdgePoint {
  float a_m = 0.0f, b_m = 0.0f, height_m = 0.0f;
};

/// By how much the base bends across the road within 0.25 m to both sides, m; 0 beside it. A kerb.
double bend_of(const RoadFrame& frame, const GridPlace& place);

/// What a cell may scatter about its plane where the base bends by so much: all of that bend is
/// wrong, or missing, at worst.
double scatter_of_bend_m(double bend_m);

/// How far over the ground a point may lie that belongs to it, m.
double most_above_ground_m(double noise_m);

/// Which of the points are a plane under all others: 1 and 0. Empty: no plane of at least a third
/// of them (and 6) that scatters as `noise_m`, a standard deviation, and has none below. Grass has
/// no such plane; a kerb or asphalt has one, however many blades hang over it.
std::vector<std::uint8_t> ground_among(const std::vector<EdgePoint>& points, double noise_m);

}  // namespace cloud
