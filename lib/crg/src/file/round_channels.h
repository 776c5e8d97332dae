// Headings and slopes in few digits whose integral still follows the line: each stored value aims
// from the point that the values before it lead to, so rounding errors do not add up.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "crg/reference_line.h"

namespace crg {

struct RoundedLine {
  std::vector<double> heading_rad;  ///< values that `round` returns
  Point2 end;                       ///< where integrating them leads
};

template <typename Round>
RoundedLine round_headings(const ReferenceLine& line, Round round) {
  RoundedLine result;
  result.heading_rad.resize(line.size());
  result.heading_rad[0] = round(line.heading_rad[0]);
  double x = line.x_m[0], y = line.y_m[0];
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double dx = line.x_m[i] - x, dy = line.y_m[i] - y;
    double heading = line.heading_rad[i];
    if (dx * dx + dy * dy > 0.0) {
      // Towards the node, on the turn of the circle that the given heading is on.
      const double turn = std::remainder(std::atan2(dy, dx) - heading, 2.0 * std::numbers::pi);
      if (std::abs(turn) < 0.1) heading += turn;
    }
    const double stored = round(heading);
    result.heading_rad[i] = stored;
    x += line.u_step_m * std::cos(stored);
    y += line.u_step_m * std::sin(stored);
  }
  result.end = {x, y};
  return result;
}

template <typename Round>
std::vector<double> round_slopes(const std::vector<double>& z_m, double u_step_m, Round round,
                                 double& end_z_m) {
  std::vector<double> slope(z_m.size());
  double z = z_m[0];
  for (std::size_t i = 1; i < z_m.size(); ++i) {
    slope[i] = round((z_m[i] - z) / u_step_m);
    z += u_step_m * slope[i];
  }
  end_z_m = z;
  return slope;
}

}  // namespace crg
