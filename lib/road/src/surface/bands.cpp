#include "bands.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace road {
namespace {

// Steady is what stays within this share of the median width.
constexpr double kSteadyWidth = 0.04;
// Roads that get wider and narrower do so over more edges than this.
constexpr std::size_t kAround = 12;

// Nothing of a band lies farther from its chain than this many widths (bends make it more than
// one).
constexpr double kBandReach = 1.4;

// Columns of the same road: equal width, no fold between them.
constexpr double kSameColumn = 0.06;

/// What is only needed until a band is complete.
struct BandParts {
  std::vector<std::pair<double, double>>
      width_and_length;  // of each edge with a triangle beside it
  std::vector<std::size_t> edge_of_triangle;
};

/// Fills triangles, width_at_m and length_m of the band.
BandParts collect(const FlatSurface& flat, const Fans& fans, const Chain& chain, Band& band) {
  BandParts raw;
  band.width_at_m.assign(chain.edges(), 0.0);
  for (std::size_t i = 0; i < chain.edges(); ++i) {
    const std::uint32_t a = chain.at(i);
    const std::uint32_t b = chain.at(i + 1);
    const std::uint32_t t = band.on_left ? fans.left(a, b) : fans.left(b, a);
    if (t == kNoIndex) continue;
    const Eigen::Vector2d along = (flat.vertices_m[b] - flat.vertices_m[a]).head<2>();
    const Eigen::Vector2d to = (flat.vertices_m[fans.apex(t, a, b)] - flat.vertices_m[a]).head<2>();
    const double length = along.norm();
    if (length <= 0.0) continue;
    raw.width_and_length.emplace_back(std::abs(along.x() * to.y() - along.y() * to.x()) / length,
                                      length);
    band.width_at_m[i] = raw.width_and_length.back().first;
    band.length_m += length;
    band.triangles.push_back(t);
    raw.edge_of_triangle.push_back(i);
    // The triangles that touch the chain at b only lie between this edge's and the next one's.
    if (!chain.closed && i + 1 >= chain.edges()) continue;
    const std::uint32_t c = chain.at(i + 2);
    std::uint32_t w = a;
    for (std::uint32_t s = t; s != kNoIndex;) {
      w = fans.apex(s, w, b);
      if (w == c) break;
      s = band.on_left ? fans.left(w, b) : fans.left(b, w);
      if (s != kNoIndex) {
        band.triangles.push_back(s);
        raw.edge_of_triangle.push_back(i);
      }
      if (band.triangles.size() > 6 * (i + 2) + 64) break;
    }
  }
  return raw;
}

/// Median width, and how much of the length is near it.
void set_width(std::vector<std::pair<double, double>> width_and_length, Band& band) {
  std::sort(width_and_length.begin(), width_and_length.end());
  double passed = 0.0;
  for (const auto& [width, length] : width_and_length) {
    passed += length;
    band.width_m = width;
    if (passed >= 0.5 * band.length_m) break;
  }
  for (const auto& [width, length] : width_and_length) {
    if (std::abs(width - band.width_m) < kSteadyWidth * band.width_m)
      band.steady += length / band.length_m;
  }
  band.rings = width_and_length.size();
}

/// Sets `smooth`; gives back the mean width around each edge.
std::vector<double> set_smooth(const FlatSurface& flat, const Chain& chain, Band& band) {
  std::vector<double> width_around(chain.edges(), band.width_m);
  for (std::size_t i = 0; i < chain.edges(); ++i) {
    if (band.width_at_m[i] <= 0.0) continue;
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t k = i - std::min(i, kAround); k < std::min(chain.edges(), i + kAround + 1);
         ++k) {
      if (band.width_at_m[k] <= 0.0) continue;
      sum += band.width_at_m[k];
      ++count;
    }
    const double mean = sum / static_cast<double>(count);
    width_around[i] = mean;
    if (std::abs(band.width_at_m[i] - mean) >= kSteadyWidth * mean) continue;
    band.smooth +=
        (flat.vertices_m[chain.at(i + 1)] - flat.vertices_m[chain.at(i)]).head<2>().norm() /
        band.length_m;
  }
  return width_around;
}

/// Drops triangles where the chain leaves the road's side at an irregular vertex, or the fan
/// reaches beyond the band.
void trim(const FlatSurface& flat, const Chain& chain,
          const std::vector<std::size_t>& edge_of_triangle, const std::vector<double>& width_around,
          Band& band) {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < band.triangles.size(); ++k) {
    const Eigen::Vector2d a = flat.vertices_m[chain.at(edge_of_triangle[k])].head<2>();
    const Eigen::Vector2d along =
        (flat.vertices_m[chain.at(edge_of_triangle[k] + 1)].head<2>() - a).normalized();
    const double width =
        band.steady >= kSteadyShare ? band.width_m : width_around[edge_of_triangle[k]];
    bool inside = band.width_at_m[edge_of_triangle[k]] > width / kBandReach;
    for (const std::uint32_t v : flat.triangles[band.triangles[k]]) {
      const Eigen::Vector2d to = flat.vertices_m[v].head<2>() - a;
      inside = inside && std::abs(along.x() * to.y() - along.y() * to.x()) < kBandReach * width;
    }
    if (inside) band.triangles[kept++] = band.triangles[k];
  }
  band.triangles.resize(kept);
}

}  // namespace

Band band_beside(const FlatSurface& flat, const Fans& fans, const std::vector<Chain>& chains,
                 std::size_t index, bool on_left) {
  Band band;
  band.chain = index;
  band.on_left = on_left;
  const Chain& chain = chains[index];
  BandParts parts = collect(flat, fans, chain, band);
  if (parts.width_and_length.empty()) {
    band.width_at_m.clear();
    return band;
  }
  set_width(std::move(parts.width_and_length), band);
  const std::vector<double> width_around = set_smooth(flat, chain, band);
  trim(flat, chain, parts.edge_of_triangle, width_around, band);
  return band;
}

bool as_wide(const Band& left, const Band& right) {
  std::size_t same = 0, all = 0;
  for (std::size_t i = 0; i < left.width_at_m.size(); ++i) {
    const double l = left.width_at_m[i], r = right.width_at_m[i];
    if (l <= 0.0 || r <= 0.0) continue;
    ++all;
    same += std::abs(l - r) < kSameColumn * std::max(l, r) ? 1 : 0;
  }
  return all > 0 && static_cast<double>(same) >= kSteadyShare * static_cast<double>(all);
}

}  // namespace road
