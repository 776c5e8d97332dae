// What even and odd laps measured of the road, over its places.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "explain/findings.h"
#include "wheel_heights.h"

namespace explain {

inline constexpr double kBinU_m = 0.2, kBinV_m = 0.5;

/// Means of a difference over places, per half of the laps.
struct Plane {
  std::size_t rows, columns;
  double right_m;
  std::array<std::vector<double>, 2> sum, count;
  Plane(double length_m, double right, double left)
      : rows(static_cast<std::size_t>(length_m / kBinU_m) + 1),
        columns(static_cast<std::size_t>((left - right) / kBinV_m) + 1),
        right_m(right) {
    for (auto& s : sum) s.assign(rows * columns, 0.0);
    for (auto& c : count) c.assign(rows * columns, 0.0);
  }
  std::size_t bin(double u, double v) const {
    const double i = u / kBinU_m, j = (v - right_m) / kBinV_m;
    if (!(i >= 0) || !(j >= 0) || i >= static_cast<double>(rows) ||
        j >= static_cast<double>(columns))
      return rows * columns;
    return static_cast<std::size_t>(i) * columns + static_cast<std::size_t>(j);
  }
  double mean(std::size_t half, std::size_t k) const {
    return count[half][k] > 0 ? sum[half][k] / count[half][k]
                              : std::numeric_limits<double>::quiet_NaN();
  }
  double both(std::size_t k) const {
    const double n = count[0][k] + count[1][k];
    return n > 0 ? (sum[0][k] + sum[1][k]) / n : std::numeric_limits<double>::quiet_NaN();
  }
};

/// The means of measured minus file without slow parts.
Plane plane_of(const std::vector<WheelHeight>& heights, double length_m, double right_m,
               double left_m);

struct Agreement {
  std::vector<double> product, energy, n;  ///< per cell
};

/// Products of the halves' means per cell, one of them moved by `shift` bins.
Agreement agree(const Plane& plane, std::size_t shift);

/// Neighbouring cells as places.
std::vector<Place> joined(const std::vector<bool>& cells);

/// The cell of a row of the plane.
std::size_t cell_of(std::size_t row);

/// The difference between road and file on these places with their means: what drifts is taken from
/// 25 m before and after each place, where the file is right, per pass of a wheel.
Plane anchored(const std::vector<WheelHeight>& heights, const std::vector<Place>& places,
               const std::vector<bool>& cells, const Plane& like);

}  // namespace explain
