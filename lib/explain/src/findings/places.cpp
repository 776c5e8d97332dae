#include "places.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace explain {

std::vector<Place> concentrated(const std::vector<double>& u_m, const std::vector<double>& energy,
                                double length_m) {
  constexpr double kCell_m = 20.0, kShare = 0.8, kJoin_m = 40.0;
  if (!(length_m > kCell_m)) return {};
  const auto cells = static_cast<std::size_t>(std::ceil(length_m / kCell_m));
  std::vector<double> sum(cells, 0.0), count(cells, 0.0);
  for (std::size_t i = 0; i < std::min(u_m.size(), energy.size()); ++i) {
    if (!(u_m[i] >= 0) || !std::isfinite(energy[i])) continue;
    const std::size_t k = std::min(cells - 1, static_cast<std::size_t>(u_m[i] / kCell_m));
    sum[k] += energy[i];
    count[k] += 1;
  }
  const double total = std::accumulate(sum.begin(), sum.end(), 0.0);
  if (!(total > 0)) return {};
  std::vector<std::size_t> order(cells);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return sum[a] > sum[b]; });
  std::vector<bool> in(cells, false);
  double held = 0.0;
  std::size_t taken = 0;
  for (const std::size_t k : order) {
    if (held >= kShare * total) break;
    in[k] = true;
    held += sum[k];
    ++taken;
  }
  if (2 * taken > cells) return {};
  std::vector<Place> out;
  for (std::size_t k = 0; k < cells; ++k) {
    if (!in[k]) continue;
    const double begin = static_cast<double>(k) * kCell_m,
                 end = std::min(length_m, begin + kCell_m);
    if (!out.empty() && begin - out.back().u_end_m < kJoin_m)
      out.back().u_end_m = end;
    else
      out.push_back({begin, end, {}});
  }
  return out;
}

}  // namespace explain
