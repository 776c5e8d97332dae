// Where a road passes over, under or through itself.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "crg/reference_line.h"

namespace road {

/// The reference line meets itself in plan at two places along u.
struct Crossing {
  double u_first_m = 0.0, u_second_m = 0.0;  ///< u_first_m < u_second_m
  double height_m = 0.0;  ///< of the second over the first, on the line; NaN where either has none
};

/// Whether both places are on one deck: a level crossing, no bridge.
bool is_level(const Crossing& crossing);

/// All crossings, by u_first_m, to a step of the line; z_m is the height of each of its nodes.
std::vector<Crossing> find_crossings(const crg::ReferenceLine& line, std::span<const double> z_m);

/// One sentence for a user: what it means for whoever asks for heights at x and y.
std::string describe(const Crossing& crossing);

}  // namespace road
