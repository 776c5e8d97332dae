#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numeric>

#include "base/statistics.h"
#include "inspect/compare.h"
#include "nan.h"

namespace road {

namespace {

constexpr double kCell_m = 0.25;  ///< also the radius around a place: its 3 x 3 cells hold it
constexpr std::size_t kFewestPoints = 6;

/// Points sorted by cell: a row of cells is one range of `order`.
struct CloudIndex {
  std::span<const Eigen::Vector3d> points_m;
  std::vector<std::uint32_t> order;
  std::vector<std::int64_t> key;  ///< of order[k], ascending

  static std::int64_t key_of(std::int64_t row, std::int64_t column) {
    return row * (std::int64_t{1} << 31) + column;
  }
  static std::int64_t cell(double at_m) {
    return static_cast<std::int64_t>(std::floor(std::clamp(at_m / kCell_m, -1e9, 1e9)));
  }
};

CloudIndex make_index(std::span<const Eigen::Vector3d> points_m) {
  CloudIndex index;
  index.points_m = points_m;
  std::vector<std::int64_t> keys;
  keys.reserve(points_m.size());
  for (const Eigen::Vector3d& p : points_m)
    keys.push_back(CloudIndex::key_of(CloudIndex::cell(p.x()), CloudIndex::cell(p.y())));
  index.order.resize(points_m.size());
  std::iota(index.order.begin(), index.order.end(), 0u);
  std::ranges::sort(index.order, [&](std::uint32_t a, std::uint32_t b) {
    return keys[a] != keys[b] ? keys[a] < keys[b] : a < b;
  });
  index.key.reserve(points_m.size());
  for (const std::uint32_t k : index.order) index.key.push_back(keys[k]);
  return index;
}

/// Height of the plane at the origin; NaN when the points do not surround it well enough to carry
/// one.
double height_of_plane(std::vector<Eigen::Vector3d>& near) {
  double height = kNan;
  for (int pass = 0; pass < 3; ++pass) {
    if (near.size() < kFewestPoints) return kNan;
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : near) {
      const Eigen::Vector3d row(1.0, p.x() / kCell_m, p.y() / kCell_m);
      normal += row * row.transpose();
      right += row * p.z();
    }
    const Eigen::Matrix3d inverse = normal.inverse();
    // The variance at the place, in that of one point: above 1 it is extrapolation.
    if (!(inverse(0, 0) > 0.0 && inverse(0, 0) < 1.0)) return kNan;
    const Eigen::Vector3d plane = inverse * right;
    height = plane(0);
    std::vector<double> off;
    for (const Eigen::Vector3d& p : near)
      off.push_back(
          std::abs(p.z() - plane(0) - plane(1) * p.x() / kCell_m - plane(2) * p.y() / kCell_m));
    const double limit = std::max(3.0 * 1.4826 * base::median(off), 1e-6);
    std::size_t kept = 0;
    for (std::size_t k = 0; k < near.size(); ++k) {
      if (off[k] <= limit) near[kept++] = near[k];
    }
    if (kept == near.size()) break;
    near.resize(kept);
  }
  return height;
}

}  // namespace

ReferenceHeights reference_of(std::span<const Eigen::Vector3d> points_m, double reach_m) {
  const auto index = std::make_shared<const CloudIndex>(make_index(points_m));
  return [index, reach_m](std::span<const crg::Point2> points, std::span<const double> z_near_m,
                          std::span<double> z_out_m) {
    std::vector<Eigen::Vector3d> near;
    for (std::size_t i = 0; i < points.size(); ++i) {
      near.clear();
      const std::int64_t row = CloudIndex::cell(points[i].x_m),
                         column = CloudIndex::cell(points[i].y_m);
      for (std::int64_t r = row - 1; r <= row + 1; ++r) {
        const auto first = std::ranges::lower_bound(index->key, CloudIndex::key_of(r, column - 1));
        for (auto k = first; k != index->key.end() && *k <= CloudIndex::key_of(r, column + 1);
             ++k) {
          const Eigen::Vector3d& p =
              index->points_m[index->order[static_cast<std::size_t>(k - index->key.begin())]];
          const Eigen::Vector3d d(p.x() - points[i].x_m, p.y() - points[i].y_m,
                                  p.z() - z_near_m[i]);
          if (d.head<2>().squaredNorm() <= kCell_m * kCell_m && std::abs(d.z()) <= reach_m)
            near.push_back(d);
        }
      }
      z_out_m[i] = z_near_m[i] + height_of_plane(near);
    }
  };
}

}  // namespace road
