#include "chains.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>
#include <utility>

#include "base/statistics.h"

namespace road {
namespace {

// The middle of a road may be its crest. It is folded alike along this share of it, whatever the
// banking; where that is least, or would be by how it goes with the bends, both sides fall away no
// more than this, nearly alike. An edge with a verge falls on one side only.
constexpr double kCrownSlope = 0.04, kCrownsDiffer = 0.01, kCrownShare = 0.8, kLevelShare = 0.2;

/// Calls use(edge, triangle to its left, to its right) for the edges of a chain that have both.
template <class Use>
void each_edge(const FlatSurface& flat, const Fans& fans, const Chain& chain, Use&& use) {
  for (std::size_t i = 0; i < chain.edges(); ++i) {
    const std::uint32_t l = fans.left(chain.at(i), chain.at(i + 1));
    const std::uint32_t r = fans.left(chain.at(i + 1), chain.at(i));
    if (l == kNoIndex || r == kNoIndex) continue;
    use(Eigen::Vector3d(flat.vertices_m[chain.at(i + 1)] - flat.vertices_m[chain.at(i)]), l, r);
  }
}

/// Rise per metre of a triangle, to the left of `along`.
double rise_to_left(const FlatSurface& flat, std::uint32_t t, const Eigen::Vector3d& along) {
  const Eigen::Vector3d n = normal_of(flat, t);
  const Eigen::Vector2d left = Eigen::Vector2d(-along.y(), along.x()).normalized();
  return -n.head<2>().dot(left) / n.z();
}

/// What a quantity that goes with the curvature would be on a straight: the line of least squares
/// through both. On a ring, which has none, its mean.
double where_straight(const std::vector<double>& quantity, const std::vector<double>& turns_1pm) {
  const auto n = static_cast<double>(quantity.size());
  double q = 0.0, t = 0.0, tt = 0.0, qt = 0.0;
  for (std::size_t i = 0; i < quantity.size(); ++i) {
    q += quantity[i] / n;
    t += turns_1pm[i] / n;
    tt += turns_1pm[i] * turns_1pm[i] / n;
    qt += quantity[i] * turns_1pm[i] / n;
  }
  constexpr double kRing = 0.1;  // of the square of the mean
  const double spread = tt - t * t;
  return spread > kRing * t * t ? q - t * (qt - q * t) / spread : q;
}

}  // namespace

std::vector<Chain> long_chains(const FlatSurface& flat, const Fans& fans, double shortest_m,
                               std::size_t fewest_edges) {
  std::vector<char> taken(fans.edges(), 0);
  std::vector<Chain> chains;
  fans.each_edge([&](std::uint32_t a, std::uint32_t b) {
    const std::size_t own = fans.edge(a, b);
    if (std::exchange(taken[own], 1)) return;
    std::deque<std::uint32_t> line{a, b};
    bool closed = false;
    for (int direction = 0; direction < 2 && !closed; ++direction) {
      std::uint32_t u = direction == 0 ? a : b;
      std::uint32_t v = direction == 0 ? b : a;
      while (true) {
        const std::uint32_t w = fans.straight_on(u, v);
        if (w == kNoIndex) break;
        const std::size_t edge = fans.edge(v, w);
        if (taken[edge]) {
          closed = edge == own && line.size() > 3;
          break;
        }
        if (fans.straight_on(w, v) != u) break;
        taken[edge] = 1;
        direction == 0 ? line.push_back(w) : line.push_front(w);
        u = v;
        v = w;
      }
    }
    Chain chain;
    if (closed && line.front() == line.back()) line.pop_back();
    chain.vertices.assign(line.begin(), line.end());
    chain.closed = closed;
    for (std::size_t i = 0; i < chain.edges(); ++i) {
      chain.length_m += (flat.vertices_m[chain.at(i + 1)] - flat.vertices_m[chain.at(i)]).norm();
    }
    if (chain.length_m >= shortest_m && chain.edges() >= fewest_edges)
      chains.push_back(std::move(chain));
  });
  return chains;
}

double fold_along(const FlatSurface& flat, const Fans& fans, const Chain& chain) {
  double sum = 0.0, length = 0.0;
  each_edge(flat, fans, chain, [&](const Eigen::Vector3d& along, std::uint32_t l, std::uint32_t r) {
    sum +=
        along.norm() * std::acos(std::clamp(normal_of(flat, l).dot(normal_of(flat, r)), -1.0, 1.0));
    length += along.norm();
  });
  return length > 0.0 ? sum / length : std::numbers::pi;
}

bool is_crest(const FlatSurface& flat, const Fans& fans, const Chain& chain) {
  double level_m = 0.0, length_m = 0.0;
  std::vector<double> folds, differ, turns_1pm, lengths_m;
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  each_edge(flat, fans, chain, [&](const Eigen::Vector3d& along, std::uint32_t l, std::uint32_t r) {
    const double left = -rise_to_left(flat, l, along), right = rise_to_left(flat, r, along);
    const double turn = before.x() * along.y() - before.y() * along.x();
    turns_1pm.push_back(before.isZero() ? 0.0 : turn / (before.norm() * along.squaredNorm()));
    before = along;
    folds.push_back(left + right);
    differ.push_back(left - right);
    lengths_m.push_back(along.norm());
    length_m += along.norm();
    if (std::min(left, right) > 0.0 && std::abs(left - right) < kCrownsDiffer)
      level_m += along.norm();
  });
  const double fold = base::median_or(0.0, folds);
  double alike_m = 0.0;
  for (std::size_t i = 0; i < folds.size(); ++i)
    if (std::abs(folds[i] - fold) < std::max(kCrownsDiffer, 0.5 * fold)) alike_m += lengths_m[i];
  return fold > 0.0 && fold < 2.0 * kCrownSlope && alike_m >= kCrownShare * length_m &&
         (level_m >= kLevelShare * length_m ||
          std::abs(where_straight(differ, turns_1pm)) < kCrownsDiffer);
}

}  // namespace road
