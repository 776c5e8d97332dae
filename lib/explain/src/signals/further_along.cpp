#include "further_along.h"

#include <algorithm>

namespace explain {

std::vector<double> further_along(const Signals& s, double shift_m) {
  std::vector<double> way_m(s.n, 0.0), out(s.n, 0.0);
  if (s.n < 2) return out;
  for (std::size_t i = 1; i < s.n; ++i) {
    const double mean_mps = 0.5 * (s.x[kVx][i - 1] + s.x[kVx][i]);
    way_m[i] = way_m[i - 1] + (mean_mps > 0 ? Signals::kStep_s * mean_mps : 0.0);
  }
  // Both places go forward together.
  for (std::size_t i = 0, k = 0; i < s.n; ++i) {
    const double wanted_m = std::clamp(way_m[i] + shift_m, 0.0, way_m.back());
    while (k + 2 < s.n && way_m[k + 1] < wanted_m) ++k;
    const double step_m = way_m[k + 1] - way_m[k];
    out[i] = static_cast<double>(k) +
             (step_m > 0 ? std::clamp((wanted_m - way_m[k]) / step_m, 0.0, 1.0) : 0.0);
  }
  return out;
}

double at_step(const std::vector<double>& x, double place) {
  const auto k = static_cast<std::size_t>(place);
  const double share = place - static_cast<double>(k);
  return share > 0 ? x[k] + share * (x[k + 1] - x[k]) : x[k];
}

}  // namespace explain
