// Functions of s as pieces of cubic polynomials, as OpenDRIVE writes them. Private to the export.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace road {

// Together less than 2 mm at the edges of the lanes.
constexpr double kWithin_m = 5e-4;
constexpr double kLongest_m = 100.0;  // piece, of whatever

/// Nodes at which pieces begin, and the last node: each piece as long as `fits` lets it be.
std::vector<std::size_t> pieces(std::size_t nodes, std::size_t most,
                                const std::function<bool(std::size_t, std::size_t)>& fits);

/// a + b s + c s^2 + d s^3
struct Cubic {
  double a = 0.0, b = 0.0, c = 0.0, d = 0.0;
  double operator()(double s) const { return a + s * (b + s * (c + s * d)); }
  double slope(double s) const { return b + s * (2.0 * c + s * 3.0 * d); }
};

/// From value and slope at both ends.
Cubic hermite(double from, double slope_from, double to, double slope_to, double length);

/// A function of s at equal steps, as it shall be written.
struct Profile {
  double step_m = 0.0;
  std::vector<std::size_t> ends;
  std::vector<Cubic> cubics;
  double worst = 0.0;  ///< distance of the cubics from the values
};

Profile fit_profile(const std::vector<double>& value, double step_m, double within);

}  // namespace road
