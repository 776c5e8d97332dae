// A plan of what changed between two campaigns.
#pragma once

#include <span>
#include <string>

namespace report {

/// A square of the map; change_m of it.
struct ChangeSquare {
  double x_m = 0.0, y_m = 0.0, change_m = 0.0;  ///< middle
};

/// A place with its number, from 1 on in the order given.
struct ChangeMark {
  double x_m = 0.0, y_m = 0.0, radius_m = 1.0;
};

/// Squares of side cell_m in blue (lower), grey (as before) and red (higher), full colour from
/// full_m on; places as rings with their numbers, below them the colours, the scale and north. The
/// bytes of a PNG file, at most 3000 pixels wide or high. Throws std::invalid_argument without
/// squares, or where a number is not finite.
std::string change_map_png(std::span<const ChangeSquare> squares, double cell_m,
                           std::span<const ChangeMark> marks, double full_m,
                           const std::string& title);

}  // namespace report
