#include "road_changes.h"

#include <algorithm>
#include <cmath>

namespace explain {

std::vector<double> profile_along(const std::vector<ProfilePoint>& profile, std::size_t rows,
                                  double u_step_m, bool closed) {
  std::vector<double> out(rows, 0.0);
  const double cell = profile[1].u_m - profile[0].u_m;
  const auto size = static_cast<std::ptrdiff_t>(profile.size());
  // One of the whole lap begins with the road and goes on behind its end.
  const double ends_m = static_cast<double>(size - (closed ? 0 : 1)) * cell;
  const double length_m = static_cast<double>(rows - 1) * u_step_m;
  const bool whole = profile.front().u_m == 0.0 && std::abs(ends_m - length_m) < 0.5 * cell;
  const auto value = [&](std::ptrdiff_t j) {
    if (whole) j = closed ? ((j % size) + size) % size : std::clamp<std::ptrdiff_t>(j, 0, size - 1);
    return j < 0 || j >= size ? 0.0 : profile[static_cast<std::size_t>(j)].value;
  };
  for (std::size_t i = 0; i < rows; ++i) {
    const double place = (static_cast<double>(i) * u_step_m - profile.front().u_m) / cell;
    const auto j = static_cast<std::ptrdiff_t>(std::floor(place + 0.5));
    const double t = place - static_cast<double>(j);
    out[i] = 0.5 * (0.5 - t) * (0.5 - t) * value(j - 1) + (0.75 - t * t) * value(j) +
             0.5 * (0.5 + t) * (0.5 + t) * value(j + 1);
  }
  return out;
}

}  // namespace explain
