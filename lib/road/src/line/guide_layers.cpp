#include "guide_layers.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "base/statistics.h"
#include "stations.h"

namespace road {
namespace {

using Eigen::Vector2d;

constexpr double kHeadroomOfLayer_m = 1.8;
constexpr double kBetweenLayers_m = 0.7;
// What a layer costs, for each row.
constexpr double kMissing = 4.0, kOtherLook = 3.5, kNarrow = 1.5, kPerMetre = 2.0,
                 kPerMetreOfGuide = 0.3, kMostOfGuide = 5.0;
constexpr double kSlopeFree = 0.2;

}  // namespace

std::vector<Layer> layers_at(const GuideRow& row, const GuideRows& all, double scale,
                             const RaySurface& surface, const LooksLikeRoad& looks_like_road) {
  struct Hit {
    double z_m, beside_m;
    bool looks;
  };
  std::vector<Hit> hits;
  constexpr int kOffsets = 5;
  for (int k = -kOffsets; k <= kOffsets; ++k) {
    const double offset_m = kBeside * all.reach_m * k / kOffsets;
    const Vector2d p = row.at_m + offset_m * left_of(row.heading);
    double roof_m = std::numeric_limits<double>::infinity();
    for (const SurfaceHit& hit : surface.all_hits(p.x(), p.y())) {  // from high to low
      const double room_m = roof_m - hit.z_m;
      if (room_m > 0.05 * scale && room_m < kHeadroomOfLayer_m * scale) continue;
      roof_m = hit.z_m;
      hits.push_back({hit.z_m, std::abs(offset_m), looks_like_road(hit.triangle)});
    }
  }
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.z_m < b.z_m; });
  std::vector<Layer> layers;
  for (std::size_t i = 0, j = 0; i < hits.size(); i = j) {
    double looks = 0.0;
    std::size_t nearest = i;
    for (j = i;
         j < hits.size() && (j == i || hits[j].z_m - hits[j - 1].z_m < kBetweenLayers_m * scale);
         ++j) {
      looks += hits[j].looks ? 1.0 : 0.0;
      if (hits[j].beside_m < hits[nearest].beside_m || (hits[j].looks && !hits[nearest].looks))
        nearest = j;
    }
    const double share = std::min(1.0, static_cast<double>(j - i) / (2 * kOffsets + 1));
    layers.push_back(
        {hits[nearest].z_m,
         kNarrow * (1.0 - share) + kOtherLook * (1.0 - looks / static_cast<double>(j - i))});
  }
  return layers;
}

void weigh_heights(const GuideRows& all, double scale, std::vector<std::vector<Layer>>& layers) {
  std::vector<double> above_m;
  for (std::size_t i = 0; i < layers.size(); ++i)
    if (layers[i].size() == 1 && std::isfinite(all.rows[i].z_m))
      above_m.push_back(layers[i][0].z_m - all.rows[i].z_m);
  if (!above_m.empty()) {
    const double shift_m = base::median(std::move(above_m));
    for (std::size_t i = 0; i < layers.size(); ++i)
      for (Layer& layer : layers[i])
        if (std::isfinite(all.rows[i].z_m))
          layer.cost +=
              std::min(kMostOfGuide,
                       kPerMetreOfGuide * std::abs(layer.z_m - all.rows[i].z_m - shift_m) / scale);
  }
}

std::vector<double> best_layers(const std::vector<std::vector<Layer>>& layers, double step_m,
                                double scale) {
  const std::size_t n = layers.size();
  std::vector<std::vector<double>> cost(n);
  std::vector<std::vector<std::size_t>> from(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t states = layers[i].size() + 1;  // the last: none
    cost[i].assign(states, std::numeric_limits<double>::infinity());
    from[i].assign(states, 0);
    for (std::size_t k = 0; k < states; ++k) {
      const double own = k + 1 == states ? kMissing : layers[i][k].cost;
      if (i == 0) {
        cost[i][k] = own;
        continue;
      }
      for (std::size_t j = 0; j < cost[i - 1].size(); ++j) {
        double change = 0.0;
        if (k + 1 < states && j + 1 < cost[i - 1].size())
          change = kPerMetre *
                   std::max(0.0, std::abs(layers[i][k].z_m - layers[i - 1][j].z_m) -
                                     kSlopeFree * step_m) /
                   scale;
        if (cost[i - 1][j] + change + own < cost[i][k])
          cost[i][k] = cost[i - 1][j] + change + own, from[i][k] = j;
      }
    }
  }
  std::vector<double> z_m(n, std::numeric_limits<double>::quiet_NaN());
  std::size_t k = static_cast<std::size_t>(
      std::min_element(cost[n - 1].begin(), cost[n - 1].end()) - cost[n - 1].begin());
  for (std::size_t i = n; i-- > 0;) {
    if (k < layers[i].size()) z_m[i] = layers[i][k].z_m;
    k = from[i][k];
  }
  return z_m;
}

}  // namespace road
