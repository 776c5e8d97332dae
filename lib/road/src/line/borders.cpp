#include "borders.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <tuple>
#include <unordered_map>

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kLargestStep_m = 0.5;                // of a border, sideways
constexpr double kLongEdge_m = 25.0;                  // no bend is drawn with longer ones
constexpr double kEach_m = 10.0, kMostParts = 100.0;  // of a long edge

/// Calls `each` with the points of the mesh's border: its vertices, and some along its long edges,
/// which would be bent where the border turns before and behind them.
template <typename Each>
void border_points_of(const Mesh& mesh, const Each& each) {
  std::vector<std::uint64_t> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = triangle[k], b = triangle[(k + 1) % 3];
      edges.push_back(std::min(a, b) << 32 | std::max(a, b));
    }
  }
  std::sort(edges.begin(), edges.end());
  std::vector<char> on_border(mesh.vertices_m.size(), 0);
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t j = i;
    while (j < edges.size() && edges[j] == edges[i]) ++j;
    if (j - i == 1) {
      const std::uint64_t a = edges[i] >> 32, b = edges[i] & 0xffffffffu;
      on_border[a] = on_border[b] = 1;
      const Vector3d from = mesh.vertices_m[a], over = mesh.vertices_m[b] - from;
      const double length_m = over.head<2>().norm();
      const double parts =
          length_m > kLongEdge_m ? std::min(std::ceil(length_m / kEach_m), kMostParts) : 1.0;
      for (double part = 1.0; part < parts; part += 1.0)
        each(mesh.origin_m + from + part / parts * over);
    }
    i = j;
  }
  for (std::size_t v = 0; v < on_border.size(); ++v)
    if (on_border[v] != 0) each(mesh.origin_m + mesh.vertices_m[v]);
}

/// The segments of a walk by the squares that they begin in.
class SegmentCells {
 public:
  explicit SegmentCells(const Walk& walk) {
    const std::size_t n = walk.stations.size();
    for (std::size_t i = 0; i < (walk.closed ? n : n - 1); ++i) {
      const Vector3d& c = walk.stations[i].centre;
      cells_[key(index(c.x()), index(c.y()))].push_back(i);
    }
  }

  /// Calls `each` with every segment that may lie within 3 squares of p.
  template <typename Each>
  void near(const Vector3d& p, const Each& each) const {
    for (std::int64_t dx = -3; dx <= 3; ++dx) {
      for (std::int64_t dy = -3; dy <= 3; ++dy) {
        const auto found = cells_.find(key(index(p.x()) + dx, index(p.y()) + dy));
        if (found == cells_.end()) continue;
        for (const std::size_t i : found->second) each(i);
      }
    }
  }

 private:
  static constexpr double kCell_m = 16.0;
  static std::int64_t index(double x) { return static_cast<std::int64_t>(std::floor(x / kCell_m)); }
  static std::int64_t key(std::int64_t ix, std::int64_t iy) {
    return (ix << 32) ^ (iy & 0xffffffff);
  }
  std::unordered_map<std::int64_t, std::vector<std::size_t>> cells_;
};

struct SidePoint {
  BorderPoint at;
  bool is_left;
};

/// Where a vertex of the border lies along the walk; nothing when it is not the road's.
std::optional<SidePoint> side_of(const Vector3d& p, const Walk& walk, const SegmentCells& cells,
                                 const std::vector<double>& station_s_m) {
  const std::size_t n = walk.stations.size();
  // An edge point lies in the stretch between two stations, as far out as their edges.
  double best_off_m = 0.4;
  std::optional<SidePoint> best;
  cells.near(p, [&](std::size_t i) {
    const Station &a = walk.stations[i], &b = walk.stations[(i + 1) % n];
    for (const bool is_left : {true, false}) {
      const Vector3d &ea = is_left ? a.left : a.right, &eb = is_left ? b.left : b.right;
      const Vector2d along = (eb - ea).head<2>();
      const double length = along.norm();
      if (length < 1e-6) continue;
      const double t = (p - ea).head<2>().dot(along) / (length * length);
      if (t < -0.02 || t > 1.02) continue;
      const double off_m = std::abs((p - ea).head<2>().dot(left_of(along / length)));
      const double dz_m = std::abs(p.z() - (ea.z() + t * (eb.z() - ea.z())));
      if (off_m >= best_off_m || dz_m > 0.5) continue;
      best_off_m = off_m;
      const double s0 = station_s_m[i];
      const double s1 = i + 1 < station_s_m.size() ? station_s_m[i + 1] : station_s_m.back();
      best = SidePoint{{s0 + std::clamp(t, 0.0, 1.0) * (s1 - s0), p}, is_left};
    }
  });
  return best;
}

/// One side in the order of the walk, without twins and steps.
std::vector<BorderPoint> in_order(std::vector<BorderPoint> side, bool closed) {
  std::sort(side.begin(), side.end(), [](const BorderPoint& a, const BorderPoint& b) {
    return std::tie(a.s_m, a.point.x(), a.point.y()) < std::tie(b.s_m, b.point.x(), b.point.y());
  });
  // Welded twins and vertices pushed out of order by noise are left out. Where the border steps
  // sideways (two ends of a track that meet beside each other) its direction would be that of the
  // step: the edge passes through the middle.
  std::vector<BorderPoint> clean;
  for (const BorderPoint& p : side) {
    const double apart_m =
        clean.empty() ? kLargestStep_m : (p.point - clean.back().point).head<2>().norm();
    if (apart_m < 0.05) continue;
    if (apart_m < kLargestStep_m && p.s_m - clean.back().s_m < 0.5 * apart_m) {
      clean.back() = {0.5 * (clean.back().s_m + p.s_m), 0.5 * (clean.back().point + p.point)};
    } else {
      clean.push_back(p);
    }
  }
  if (closed && clean.size() > 2 &&
      (clean.back().point - clean.front().point).head<2>().norm() < 0.05) {
    clean.pop_back();
  }
  return clean;
}

}  // namespace

std::vector<double> places_along(const Walk& walk) {
  std::vector<double> station_s_m{0.0};
  const std::size_t n = walk.stations.size();
  for (std::size_t i = 0; i < (walk.closed ? n : n - 1); ++i) {
    station_s_m.push_back(
        station_s_m.back() +
        (walk.stations[(i + 1) % n].centre - walk.stations[i].centre).head<2>().norm());
  }
  return station_s_m;
}

std::pair<std::vector<BorderPoint>, std::vector<BorderPoint>> borders_along(
    const Mesh& mesh, const Walk& walk, const std::vector<double>& station_s_m) {
  const SegmentCells cells(walk);
  std::vector<BorderPoint> left, right;
  border_points_of(mesh, [&](const Vector3d& p) {
    if (const auto found = side_of(p, walk, cells, station_s_m))
      (found->is_left ? left : right).push_back(found->at);
  });
  return {in_order(std::move(left), walk.closed), in_order(std::move(right), walk.closed)};
}

}  // namespace road
