#include "outliers.h"

#include <Eigen/Dense>
#include <algorithm>
#include <limits>
#include <random>
#include <utility>

#include "base/statistics.h"

namespace road {
namespace {

constexpr std::size_t kMostTriples = 5000;

using Rotation = AlignOptions::Rotation;

/// The smallest sets of points that fix a motion, spread over all: pairs, or triples for a free
/// rotation.
std::vector<Indices> smallest_sets(const AlignOptions& options,
                                   const std::vector<ControlPoint>& points) {
  const std::size_t n = points.size();
  const auto apart = [&](std::size_t i, std::size_t j) {
    return (points[i].mesh_m - points[j].mesh_m).head<2>().norm() >= kSmallestSpread_m;
  };
  std::vector<Indices> sets;
  if (options.rotation == Rotation::about_z) {
    // Pairs far apart fix the rotation; more than 20,000 pairs tell nothing new.
    const std::size_t step = std::max<std::size_t>(1, n * n / 40'000);
    std::size_t pair = 0;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) {
        if (pair++ % step == 0 && apart(i, j)) sets.push_back({i, j});
      }
    }
    return sets;
  }
  const auto add = [&](std::size_t i, std::size_t j, std::size_t k) {
    const Eigen::Vector3d a = points[j].mesh_m - points[i].mesh_m,
                          b = points[k].mesh_m - points[i].mesh_m;
    // Twice as high over its longest side as points have to be apart.
    if (apart(i, j) && apart(i, k) && apart(j, k) &&
        a.cross(b).norm() >=
            2.0 * kSmallestSpread_m * std::max({a.norm(), b.norm(), (a - b).norm()}))
      sets.push_back({i, j, k});
  };
  if (n * n * n <= 6 * kMostTriples) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) {
        for (std::size_t k = j + 1; k < n; ++k) add(i, j, k);
      }
    }
    return sets;
  }
  std::mt19937_64 random(1);
  for (std::size_t tries = 0; tries < kMostTriples; ++tries) {
    const std::size_t i = random() % n, j = random() % n, k = random() % n;
    if (i != j && j != k && k != i) add(i, j, k);
  }
  return sets;
}

}  // namespace

base::Answer<Indices> inliers(const std::vector<ControlPoint>& points,
                              const AlignOptions& options) {
  Indices all = all_of(points.size());
  const std::size_t least = options.rotation == Rotation::free ? 3 : 2;
  if (!options.reject_outliers || points.size() < least + 2) return all;
  double best = std::numeric_limits<double>::infinity();
  Similarity best_T;
  for (const Indices& set : smallest_sets(options, points)) {
    const auto T = fit_as(options, points, set);
    if (!T) return T.refusal();
    std::vector<double> distances;
    for (const ControlPoint& point : points) distances.push_back(residual(*T, point));
    const double middle = base::median(std::move(distances));
    if (middle < best) {
      best = middle;
      best_T = *T;
    }
  }
  Indices used;
  for (int pass = 0; pass < 3; ++pass) {
    // 1.48 medians are one standard deviation of normal noise; so few points fit a little worse
    // than all.
    const double limit_m = std::max(options.smallest_outlier_m, 4.0 * 1.48 * best);
    used.clear();
    std::vector<double> distances;
    for (const std::size_t i : all) {
      if (residual(best_T, points[i]) <= limit_m) used.push_back(i);
    }
    if (used.size() < least) break;
    const auto T = fit_as(options, points, used);
    if (!T) return T.refusal();
    best_T = *T;
    for (const std::size_t i : used) distances.push_back(residual(best_T, points[i]));
    best = base::median(std::move(distances));
  }
  return used.size() * 2 > points.size() ? used : all;
}

}  // namespace road
