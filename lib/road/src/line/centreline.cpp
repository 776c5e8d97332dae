#include "road/centreline.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "base/csv.h"
#include "base/statistics.h"
#include "base/write_file.h"
#include "fork.h"
#include "guide_rows.h"
#include "road/error.h"
#include "road_graph.h"
#include "stations.h"
#include "walk_along.h"
#include "walk_road.h"

namespace road {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kShortestLoopWidths = 10.0;  // a shorter loop is a traffic island
constexpr double kLostShare =
    1.2;  // the graph's ways are 3 to 6 % too long: their cells make steps
constexpr double kSmallestWidth_m = 0.2;
constexpr double kLargestStep_m = 0.5;  // of a border, sideways
constexpr double kSecondWay = 0.3;      // of the longest way: a shorter one is a branch
constexpr double kUnlike = 0.3;         // of half the width, along a guide
constexpr double kUnlikeHeld = 0.03;    // and where one edge is known to be the other road's

double angle_between(const Vector2d& from, const Vector2d& to) {
  return std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
}

/// Triangles of class road only, or all of them where nothing is called road.
Mesh road_only(const RoadMesh& road) {
  Mesh mesh = road.mesh;
  const auto is_road = [&](std::size_t t) {
    return road.class_of_triangle[t] == SurfaceClass::road;
  };
  std::size_t kept = 0;
  for (std::size_t t = 0; t < road.mesh.triangles.size(); ++t) {
    if (!is_road(t)) continue;
    mesh.triangles[kept] = road.mesh.triangles[t];
    mesh.object_of_triangle[kept] = road.mesh.object_of_triangle[t];
    ++kept;
  }
  if (kept == 0) return mesh;
  mesh.triangles.resize(kept);
  mesh.object_of_triangle.resize(kept);
  return mesh;
}

/// What the graph shows, as long as it is one closed road and no other beside it.
std::optional<RoadWay> closed_way(const RoadGraph& graph, const CentrelineOptions& options) {
  std::vector<RoadWay> ways = road_ways(graph, kGapAlong_m);
  std::erase_if(ways, [](const RoadWay& way) {
    const double width_m = 2.0 * base::median(way.half_width_m);
    return !way.closed || width_m < kMinWidth_m || width_m > kMaxWidth_m ||
           way.length_m < kShortestLoopWidths * width_m;
  });
  const auto distance_m = [&](const RoadWay& way) {
    double best = std::numeric_limits<double>::infinity();
    for (const Vector3d& p : way.points_m)
      best = std::min(best, (p.head<2>() - *options.start_near_m).norm());
    return best;
  };
  const auto together = [](const RoadWay& a, const RoadWay& b) {
    return std::find_first_of(a.branches.begin(), a.branches.end(), b.branches.begin(),
                              b.branches.end()) != a.branches.end();
  };
  if (ways.empty()) return std::nullopt;
  if (options.start_near_m) {
    const RoadWay nearest = *std::min_element(
        ways.begin(), ways.end(),
        [&](const RoadWay& a, const RoadWay& b) { return distance_m(a) < distance_m(b); });
    std::erase_if(ways, [&](const RoadWay& way) { return !together(way, nearest); });
  }
  for (std::size_t i = 1; i < ways.size(); ++i)
    if (!together(ways[0], ways[i]) && ways[i].length_m > 0.5 * ways[0].length_m)
      return std::nullopt;
  return main_way(graph, ways);
}

/// The one way of a graph that has no second one to speak of.
std::optional<RoadWay> only_way(const RoadGraph& graph) {
  const std::vector<RoadWay> ways = road_ways(graph, 0.0, 2);
  if (ways.empty() || (ways.size() > 1 && ways[1].length_m > kSecondWay * ways[0].length_m))
    return std::nullopt;
  const double width_m = 2.0 * base::median(ways[0].half_width_m);
  if (width_m < kMinWidth_m || width_m > kMaxWidth_m ||
      ways[0].length_m < kShortestLoopWidths * width_m)
    return std::nullopt;
  return ways[0];
}

/// The way along the guide, in the middle of the surface; without width where nothing tells where
/// that is.
RoadWay way_along(const Guide& guide, const RaySurface& surface,
                  std::optional<double> width_m = {}) {
  GuideRows all = rows_along(guide, surface, [](std::uint32_t) { return true; });
  if (width_m && all.usual_half_m > 0.0) set_width(all, *width_m);
  RoadWay way;
  way.closed = all.closed;
  for (const GuideRow& row : all.rows) {
    const Vector2d p = row.at_m + row.middle_m * left_of(row.heading);
    way.points_m.emplace_back(p.x(), p.y(), row.z_m);
    way.half_width_m.push_back(row.half_width_m);
  }
  return way;
}

/// The road of the surface: what lies along the guide; else what a walk finds, unless the graph of
/// the surface shows a closed road that the walk has lost or only a part of which it has found.
Walk find_road(const Mesh& mesh, const RaySurface& surface, const RoadGraph& graph,
               const std::optional<Guide>& guide, const CentrelineOptions& options) {
  if (guide) {
    const RoadWay way = way_along(*guide, surface, options.guide_width_m);
    if (base::median(way.half_width_m) == 0.0)
      throw Error(
          "nothing on the surface along the guide tells where the road ends; say how wide it is "
          "(--guide-width-m W, guide_width_m in a recipe)");
    return walk_along(surface, way, false, true);
  }
  const std::optional<RoadWay> way = closed_way(graph, options);
  if (!way) {
    try {
      return walk_road(mesh, surface, options);
    } catch (const Error&) {
      const std::optional<RoadWay> only = only_way(graph);
      if (!only) throw;
      return walk_along(surface, *only);
    }
  }
  try {
    Walk walk = walk_road(mesh, surface, options);
    if (walk.closed && way->length_m < kLostShare * walk.length_m &&
        (forks_of(graph, *way).empty() || keeps_to(walk, *way, graph.cell_m)))
      return walk;
  } catch (const Error&) {  // the graph knows better
  }
  return walk_along(surface, *way);
}

/// Squares every station to the line through its neighbours and measures the edges again.
void refine(const RaySurface& surface, Walk& walk) {
  const std::size_t n = walk.stations.size();
  const std::vector<Station> old = walk.stations;
  for (std::size_t i = 0; i < n; ++i) {
    const Station& before = old[i == 0 ? (walk.closed ? n - 1 : 0) : i - 1];
    const Station& after = old[i + 1 == n ? (walk.closed ? 0 : n - 1) : i + 1];
    const Vector2d heading = (after.centre - before.centre).head<2>().normalized(),
                   normal = left_of(heading);
    const double half_m = 0.5 * old[i].width_m(), limit_m = 1.5 * half_m;
    const Station measured = cross_section(surface, old[i].centre, heading, limit_m, limit_m);
    // A side that differs much is a hole or a branch which the walk has passed: its word stands.
    const auto settle = [&](double measured_m) {
      return std::abs(measured_m - half_m) < 0.3 + 0.05 * half_m ? measured_m : half_m;
    };
    const Vector2d centre = old[i].centre.head<2>();
    const double left_m = settle((measured.left.head<2>() - centre).dot(normal));
    const double right_m = settle(-(measured.right.head<2>() - centre).dot(normal));
    Station& refined = walk.stations[i];
    refined.left << centre + left_m * normal, measured.left.z();
    refined.right << centre - right_m * normal, measured.right.z();
    refined.centre << 0.5 * (refined.left + refined.right).head<2>(), measured.centre.z();
    refined.heading = heading;
  }
}

/// A point with its place along the walk.
struct EdgePoint {
  double s_m;
  Vector3d point;
};

/// Piecewise cubic through points, tangents from the circle through three neighbours.
class EdgeCurve {
 public:
  EdgeCurve(std::vector<EdgePoint> points, bool closed)
      : points_(std::move(points)), closed_(closed) {
    const std::size_t n = points_.size();
    tangents_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const bool first = i == 0 && !closed_, last = i + 1 == n && !closed_;
      const Vector2d here = xy(i);
      const Vector2d a = first ? Vector2d(xy(i + 1) - here) : Vector2d(here - xy((i + n - 1) % n));
      const Vector2d b = last ? a : Vector2d(xy((i + 1) % n) - here);
      const double la = std::max(a.norm(), 1e-9), lb = std::max(b.norm(), 1e-9);
      // Weighted so that points on a circle give its exact tangent, whatever their spacing.
      tangents_[i] = (a / la * lb + b / lb * la).normalized();
    }
  }

  std::size_t size() const { return points_.size(); }
  const EdgePoint& operator[](std::size_t i) const { return points_[i]; }
  const Vector2d& tangent(std::size_t i) const { return tangents_[i]; }
  std::size_t segments() const { return closed_ ? points_.size() : points_.size() - 1; }
  std::size_t next(std::size_t i) const { return i + 1 == points_.size() ? 0 : i + 1; }

  /// Point and direction at share t in [0, 1] of segment i.
  std::pair<Vector3d, Vector2d> at(std::size_t i, double t) const {
    const std::size_t j = next(i);
    const Vector3d &p = points_[i].point, &q = points_[j].point;
    const double length = (q - p).head<2>().norm();
    const Vector2d m0 = length * tangents_[i], m1 = length * tangents_[j];
    const double t2 = t * t, t3 = t2 * t;
    const Vector2d position = (2 * t3 - 3 * t2 + 1) * p.head<2>() + (t3 - 2 * t2 + t) * m0 +
                              (-2 * t3 + 3 * t2) * q.head<2>() + (t3 - t2) * m1;
    const Vector2d derivative = (6 * t2 - 6 * t) * p.head<2>() + (3 * t2 - 4 * t + 1) * m0 +
                                (-6 * t2 + 6 * t) * q.head<2>() + (3 * t2 - 2 * t) * m1;
    return {{position.x(), position.y(), p.z() + t * (q.z() - p.z())}, derivative.normalized()};
  }

  /// Segment whose stretch of s holds s_m.
  std::size_t segment_of(double s_m) const {
    const auto after = std::upper_bound(points_.begin(), points_.end(), s_m,
                                        [](double s, const EdgePoint& p) { return s < p.s_m; });
    if (after == points_.begin()) return closed_ ? points_.size() - 1 : 0;
    return std::min<std::size_t>(static_cast<std::size_t>(after - points_.begin()) - 1,
                                 segments() - 1);
  }

 private:
  Vector2d xy(std::size_t i) const { return points_[i].point.head<2>(); }
  std::vector<EdgePoint> points_;
  std::vector<Vector2d> tangents_;
  bool closed_;
};

/// Vertices on the border of the road surface, as left and right edge along the walk.
/// A mesh is exact at its vertices and cuts corners between them, so edges are taken from these.
void collect_edges(const Mesh& mesh, const Walk& walk, const std::vector<double>& station_s_m,
                   std::vector<EdgePoint>& left, std::vector<EdgePoint>& right) {
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
      on_border[edges[i] >> 32] = 1;
      on_border[edges[i] & 0xffffffffu] = 1;
    }
    i = j;
  }

  constexpr double kCell_m = 16.0;
  std::unordered_map<std::int64_t, std::vector<std::size_t>> cells;
  const auto key = [](std::int64_t ix, std::int64_t iy) { return (ix << 32) ^ (iy & 0xffffffff); };
  const auto index = [](double x) { return static_cast<std::int64_t>(std::floor(x / kCell_m)); };
  const std::size_t n = walk.stations.size();
  const std::size_t segments = walk.closed ? n : n - 1;
  for (std::size_t i = 0; i < segments; ++i) {
    const Vector3d& c = walk.stations[i].centre;
    cells[key(index(c.x()), index(c.y()))].push_back(i);
  }
  for (std::size_t v = 0; v < mesh.vertices_m.size(); ++v) {
    if (on_border[v] == 0) continue;
    const Vector3d p = mesh.origin_m + mesh.vertices_m[v];
    // An edge point lies in the stretch between two stations, as far out as their edges.
    double best_off_m = 0.4;
    std::optional<EdgePoint> best;
    bool best_left = false;
    for (std::int64_t dx = -3; dx <= 3; ++dx) {
      for (std::int64_t dy = -3; dy <= 3; ++dy) {
        const auto found = cells.find(key(index(p.x()) + dx, index(p.y()) + dy));
        if (found == cells.end()) continue;
        for (const std::size_t i : found->second) {
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
            best = EdgePoint{s0 + std::clamp(t, 0.0, 1.0) * (s1 - s0), p};
            best_left = is_left;
          }
        }
      }
    }
    if (best) (best_left ? left : right).push_back(*best);
  }
  for (auto* side : {&left, &right}) {
    std::sort(side->begin(), side->end(), [](const EdgePoint& a, const EdgePoint& b) {
      return std::tie(a.s_m, a.point.x(), a.point.y()) < std::tie(b.s_m, b.point.x(), b.point.y());
    });
    // Welded twins and vertices pushed out of order by noise are left out. Where the border steps
    // sideways (two ends of a track that meet beside each other) its direction would be that of the
    // step: the edge passes through the middle.
    std::vector<EdgePoint> clean;
    for (const EdgePoint& p : *side) {
      const double apart_m =
          clean.empty() ? kLargestStep_m : (p.point - clean.back().point).head<2>().norm();
      if (apart_m < 0.05) continue;
      if (apart_m < kLargestStep_m && p.s_m - clean.back().s_m < 0.5 * apart_m) {
        clean.back() = {0.5 * (clean.back().s_m + p.s_m), 0.5 * (clean.back().point + p.point)};
      } else {
        clean.push_back(p);
      }
    }
    if (walk.closed && clean.size() > 2 &&
        (clean.back().point - clean.front().point).head<2>().norm() < 0.05) {
      clean.pop_back();
    }
    *side = std::move(clean);
  }
}

/// The other edge's point opposite to point i of `from`: the chord makes equal angles with both
/// edges.
std::optional<Vector3d> opposite(const EdgeCurve& from, std::size_t i, const EdgeCurve& to) {
  const Vector2d p = from[i].point.head<2>();
  const Vector2d& tangent = from.tangent(i);
  const auto off = [&](const std::pair<Vector3d, Vector2d>& q) {
    return (q.first.head<2>() - p).dot(tangent + q.second);
  };
  std::size_t segment = to.segment_of(from[i].s_m);
  // Walk to the segment that holds the sign change.
  for (int tries = 0; tries < 40; ++tries) {
    const double at_begin = off(to.at(segment, 0.0)), at_end = off(to.at(segment, 1.0));
    if (at_begin > 1e-9) {
      if (segment == 0 && to.segments() < to.size()) return std::nullopt;
      segment = segment == 0 ? to.segments() - 1 : segment - 1;
      if (off(to.at(segment, 0.0)) <= 1e-9 && off(to.at(segment, 1.0)) < -1e-9) return std::nullopt;
    } else if (at_end < -1e-9) {
      if (segment + 1 == to.segments() && to.segments() < to.size()) return std::nullopt;
      segment = segment + 1 == to.segments() ? 0 : segment + 1;
      if (off(to.at(segment, 0.0)) > 1e-9) return std::nullopt;
    } else {
      double lo = 0.0, hi = 1.0;
      for (int k = 0; k < 50; ++k) {
        const double t = 0.5 * (lo + hi);
        (off(to.at(segment, t)) < 0.0 ? lo : hi) = t;
      }
      return to.at(segment, 0.5 * (lo + hi)).first;
    }
  }
  return std::nullopt;
}

struct Middle {
  double s_m;
  Vector3d point;
  double half_width_m;
};

std::vector<Middle> middles_of(const RaySurface& surface, const Walk& walk, const EdgeCurve& left,
                               const EdgeCurve& right) {
  std::vector<Middle> middles;
  const double typical_half_m = 0.5 * walk.area_m2 / std::max(walk.length_m, 1.0);
  for (const bool from_left : {true, false}) {
    const EdgeCurve &from = from_left ? left : right, &to = from_left ? right : left;
    for (std::size_t i = 0; i < from.size(); ++i) {
      const auto other = opposite(from, i, to);
      if (!other) continue;
      const Vector3d middle = 0.5 * (from[i].point + *other);
      const double half_m = 0.5 * (from[i].point - *other).head<2>().norm();
      if (half_m > 3.0 * typical_half_m + 2.0) continue;
      const auto hit = surface.nearest_hit(middle.x(), middle.y(), middle.z(), 2.0 * kLayerReach_m);
      middles.push_back(
          {from[i].s_m, {middle.x(), middle.y(), hit ? hit->z_m : middle.z()}, half_m});
    }
  }
  return middles;
}

/// Sorts middles along the road and merges those that stand for the same cross-section.
std::vector<Middle> ordered(std::vector<Middle> middles, const Walk& walk,
                            const std::vector<double>& station_s_m) {
  // s of an edge point is not the s of its middle: project the middle on the walk.
  const std::size_t n = walk.stations.size();
  const std::size_t segments = walk.closed ? n : n - 1;
  for (Middle& m : middles) {
    const auto near = static_cast<std::size_t>(
        std::upper_bound(station_s_m.begin(), station_s_m.end(), m.s_m) - station_s_m.begin());
    double best_m = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 25; ++k) {
      std::size_t i = near + n + k - 13;
      if (walk.closed) {
        i %= n;
      } else if (i < n || i >= n + segments) {
        continue;
      } else {
        i -= n;
      }
      const Vector2d a = walk.stations[i].centre.head<2>(),
                     b = walk.stations[(i + 1) % n].centre.head<2>();
      const double t = std::clamp(
          (m.point.head<2>() - a).dot(b - a) / std::max((b - a).squaredNorm(), 1e-12), 0.0, 1.0);
      const double d = (m.point.head<2>() - (a + t * (b - a))).norm();
      if (d < best_m) {
        best_m = d;
        m.s_m = station_s_m[i] + t * (station_s_m[i + 1] - station_s_m[i]);
      }
    }
  }
  std::sort(middles.begin(), middles.end(), [](const Middle& a, const Middle& b) {
    return std::tie(a.s_m, a.point.x(), a.point.y()) < std::tie(b.s_m, b.point.x(), b.point.y());
  });
  std::vector<Middle> result;
  double weight = 1.0;
  for (const Middle& m : middles) {
    if (!result.empty() && m.s_m - result.back().s_m < 0.5) {
      Middle& last = result.back();
      weight += 1.0;
      last.point += (m.point - last.point) / weight;
      last.half_width_m += (m.half_width_m - last.half_width_m) / weight;
      last.s_m += (m.s_m - last.s_m) / weight;
    } else {
      result.push_back(m);
      weight = 1.0;
    }
  }
  return result;
}

/// Whether a cross-section is like the walk's there; at junctions a border may be that of another
/// road.
bool agrees(const Middle& middle, const Walk& walk, const std::vector<double>& station_s_m,
            double unlike) {
  const std::size_t n = walk.stations.size();
  const auto after = static_cast<std::size_t>(
      std::upper_bound(station_s_m.begin(), station_s_m.end(), middle.s_m) - station_s_m.begin());
  const std::size_t b = std::min(after, station_s_m.size() - 1), a = b == 0 ? 0 : b - 1;
  const double t =
      b == a ? 0.0
             : (middle.s_m - station_s_m[a]) / std::max(station_s_m[b] - station_s_m[a], 1e-9);
  const Station &from = walk.stations[a], &to = walk.stations[b % n];
  const Vector2d place = from.centre.head<2>() + t * (to.centre - from.centre).head<2>();
  const double half_m = 0.5 * (from.width_m() + t * (to.width_m() - from.width_m()));
  return (middle.point.head<2>() - place).norm() < unlike * half_m &&
         std::abs(middle.half_width_m - half_m) < unlike * half_m;
}

/// Length along the cubic through the stations; 8 chords per segment keep the error below 1e-6 of
/// it.
double curve_length_m(const std::vector<Vector3d>& points, bool closed) {
  std::vector<EdgePoint> edge_points;
  edge_points.reserve(points.size());
  for (const Vector3d& p : points) edge_points.push_back({0.0, p});
  const EdgeCurve curve(std::move(edge_points), closed);
  double length = 0.0;
  for (std::size_t i = 0; i < curve.segments(); ++i) {
    Vector2d last = curve.at(i, 0.0).first.head<2>();
    for (int k = 1; k <= 8; ++k) {
      const Vector2d next = curve.at(i, k / 8.0).first.head<2>();
      length += (next - last).norm();
      last = next;
    }
  }
  return length;
}

/// Middle of the longest stretch that turns by less than 3 degrees: a calm place for the seam.
std::size_t middle_of_longest_straight(const std::vector<Vector3d>& points) {
  const std::size_t n = points.size();
  const auto xy = [&](std::size_t i) -> Vector2d { return points[i % n].head<2>(); };
  std::size_t best_begin = 0, best_end = 0;
  double best_m = -1.0;
  std::size_t end = 1;
  double length_m = (xy(1) - xy(0)).norm();
  for (std::size_t begin = 0; begin < n; ++begin) {
    if (end <= begin) {
      end = begin + 1;
      length_m = (xy(end) - xy(begin)).norm();
    }
    const Vector2d first = xy(begin + 1) - xy(begin);
    while (end - begin < n - 1 && std::abs(angle_between(first, xy(end + 1) - xy(end))) < 0.05) {
      length_m += (xy(end + 1) - xy(end)).norm();
      ++end;
    }
    if (length_m > best_m + 1e-6) {
      best_m = length_m;
      best_begin = begin;
      best_end = end;
    }
    length_m -= (xy(begin + 1) - xy(begin)).norm();
  }
  // The station nearest to half of the stretch.
  double half_m = 0.5 * best_m;
  std::size_t i = best_begin;
  while (i + 1 < best_end && half_m > (xy(i + 1) - xy(i)).norm())
    half_m -= (xy(i + 1) - xy(i)).norm(), ++i;
  return i % n;
}

/// Makes the place nearest to `p` station 0; a new station is put in where none lies there.
void start_at(Centreline& line, const Vector2d& p) {
  std::vector<EdgePoint> points;
  points.reserve(line.points_m.size());
  for (const Vector3d& q : line.points_m) points.push_back({0.0, q});
  const EdgeCurve curve(std::move(points), line.closed);
  double best_m = std::numeric_limits<double>::infinity();
  std::size_t segment = 0;
  double share = 0.0;
  for (std::size_t i = 0; i < curve.segments(); ++i) {
    for (int k = 0; k <= 16; ++k) {
      const double d = (curve.at(i, k / 16.0).first.head<2>() - p).norm();
      if (d < best_m) {
        best_m = d;
        segment = i;
        share = k / 16.0;
      }
    }
  }
  double lo = std::max(0.0, share - 1.0 / 16), hi = std::min(1.0, share + 1.0 / 16);
  for (int k = 0; k < 60; ++k) {
    const double a = lo + (hi - lo) / 3, b = hi - (hi - lo) / 3;
    if ((curve.at(segment, a).first.head<2>() - p).norm() <
        (curve.at(segment, b).first.head<2>() - p).norm()) {
      hi = b;
    } else {
      lo = a;
    }
  }
  share = 0.5 * (lo + hi);
  const std::size_t next = curve.next(segment);
  const double length_m = (line.points_m[next] - line.points_m[segment]).head<2>().norm();
  std::size_t first = share < 0.5 ? segment : next;
  if (std::min(share, 1.0 - share) * length_m > 0.5) {
    const Vector3d point = curve.at(segment, share).first;
    const double half_m =
        line.half_width_m[segment] + share * (line.half_width_m[next] - line.half_width_m[segment]);
    first = segment + 1;
    line.points_m.insert(line.points_m.begin() + static_cast<std::ptrdiff_t>(first), point);
    line.half_width_m.insert(line.half_width_m.begin() + static_cast<std::ptrdiff_t>(first),
                             half_m);
  } else {
    line.points_m[first] = curve.at(segment, share).first;
  }
  std::rotate(line.points_m.begin(), line.points_m.begin() + static_cast<std::ptrdiff_t>(first),
              line.points_m.end());
  std::rotate(line.half_width_m.begin(),
              line.half_width_m.begin() + static_cast<std::ptrdiff_t>(first),
              line.half_width_m.end());
}

std::optional<Vector2d> middle_of_object(const Mesh& mesh, const std::string& name) {
  Eigen::AlignedBox2d box;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.objects[mesh.object_of_triangle[t]].name != name) continue;
    for (int k = 0; k < 3; ++k) box.extend(Vector2d((mesh.origin_m + mesh.vertex(t, k)).head<2>()));
  }
  if (box.isEmpty()) return std::nullopt;
  return box.center();
}

double signed_area_m2(const std::vector<Vector3d>& points) {
  double area = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d &a = points[i], &b = points[(i + 1) % points.size()];
    area += 0.5 * ((a.x() - points[0].x()) * (b.y() - points[0].y()) -
                   (b.x() - points[0].x()) * (a.y() - points[0].y()));
  }
  return area;
}

Centreline trace(const Mesh& mesh, const RoadGraph& graph, const std::optional<Guide>& guide,
                 const CentrelineOptions& options) {
  const RaySurface surface(mesh);
  Walk walk = find_road(mesh, surface, graph, guide, options);
  refine(surface, walk);
  measure(walk);
  std::vector<Stretch> held;
  if (!guide && walk.closed)
    if (const auto way = closed_way(graph, options)) {
      held = hold_through_forks(surface, *way, forks_of(graph, *way), walk);
      measure(walk);
    }

  std::vector<double> station_s_m{0.0};
  const std::size_t n = walk.stations.size();
  for (std::size_t i = 0; i < (walk.closed ? n : n - 1); ++i) {
    station_s_m.push_back(
        station_s_m.back() +
        (walk.stations[(i + 1) % n].centre - walk.stations[i].centre).head<2>().norm());
  }

  const auto is_held = [&](double s_m) {
    return std::any_of(held.begin(), held.end(), [&](const Stretch& stretch) {
      const double begin_m = station_s_m[stretch.begin], end_m = station_s_m[stretch.end];
      return begin_m <= end_m ? s_m >= begin_m && s_m <= end_m : s_m >= begin_m || s_m <= end_m;
    });
  };

  Centreline line;
  line.closed = walk.closed;
  std::vector<EdgePoint> left, right;
  collect_edges(mesh, walk, station_s_m, left, right);
  std::vector<Middle> middles;
  if (left.size() >= 4 && right.size() >= 4) {
    const EdgeCurve left_curve(std::move(left), walk.closed);
    const EdgeCurve right_curve(std::move(right), walk.closed);
    middles = ordered(middles_of(surface, walk, left_curve, right_curve), walk, station_s_m);
    std::erase_if(middles, [&](const Middle& m) {
      const bool held_here = is_held(m.s_m);
      return (guide || held_here) &&
             !agrees(m, walk, station_s_m, held_here ? kUnlikeHeld : kUnlike);
    });
  }
  // Where the mesh's border told too little, the walk itself fills in.
  std::vector<Middle> complete;
  const auto fill = [&](double from_m, double to_m) {
    for (std::size_t i = 0; i < n; ++i) {
      const double longest_bare_m = guide || is_held(station_s_m[i]) ? 10.0 : 40.0;
      if (to_m - from_m >= longest_bare_m && station_s_m[i] > from_m + 1.0 &&
          station_s_m[i] < to_m - 1.0) {
        complete.push_back(
            {station_s_m[i], walk.stations[i].centre, 0.5 * walk.stations[i].width_m()});
      }
    }
  };
  double last_m = walk.closed && !middles.empty() ? middles.back().s_m - station_s_m.back() : 0.0;
  for (const Middle& m : middles) {
    fill(std::max(last_m, -1.1), m.s_m);
    complete.push_back(m);
    last_m = m.s_m;
  }
  if (!walk.closed || middles.empty()) {
    fill(last_m - (middles.empty() ? 1.1 : 0.0), station_s_m.back() + 1.1);
    // An open road ends where the surface ends, not at the last ring that both edges share.
    if (!walk.closed && !complete.empty()) {
      if (complete.front().s_m > 0.5) {
        complete.insert(complete.begin(),
                        {0.0, walk.stations.front().centre, 0.5 * walk.stations.front().width_m()});
      }
      if (complete.back().s_m < station_s_m.back() - 0.5) {
        complete.push_back({station_s_m.back(), walk.stations.back().centre,
                            0.5 * walk.stations.back().width_m()});
      }
    }
  }
  for (const Middle& m : complete) {
    line.points_m.push_back(m.point);
    line.half_width_m.push_back(m.half_width_m);
  }
  if (line.points_m.size() < 4)
    throw Error(fmt::format("the road found is too short: {}", describe(walk)));

  // Counter-clockwise unless asked otherwise; an open road keeps the order of its walk's longer
  // axis. A guide is followed.
  const bool backwards = guide ? false
                         : line.closed
                             ? signed_area_m2(line.points_m) < 0.0
                             : (line.points_m.back() - line.points_m.front()).head<2>().sum() < 0.0;
  if (backwards != options.reverse) {
    std::reverse(line.points_m.begin(), line.points_m.end());
    std::reverse(line.half_width_m.begin(), line.half_width_m.end());
  }
  if (line.closed) {
    if (options.start_near_m) {
      start_at(line, *options.start_near_m);
    } else if (guide) {
      start_at(line, guide->points_m.front().head<2>());
    } else {
      const auto first = static_cast<std::ptrdiff_t>(middle_of_longest_straight(line.points_m));
      std::rotate(line.points_m.begin(), line.points_m.begin() + first, line.points_m.end());
      std::rotate(line.half_width_m.begin(), line.half_width_m.begin() + first,
                  line.half_width_m.end());
    }
  }
  line.length_m = curve_length_m(line.points_m, line.closed);
  return line;
}

/// The guide itself, where the surface goes on on both sides: smoothed over a road's width.
Centreline along_guide(const RoadWay& way, double width_m, bool reverse) {
  Centreline line;
  line.closed = way.closed;
  line.points_m = way.points_m;
  line.half_width_m.assign(way.points_m.size(), 0.5 * width_m);
  if (reverse) std::reverse(line.points_m.begin(), line.points_m.end());
  line.length_m = curve_length_m(line.points_m, line.closed);
  return line;
}

double typical_width_m(const RoadGraph& graph) {
  std::vector<double> half_width_m;
  for (const RoadBranch& branch : graph.branches)
    half_width_m.insert(half_width_m.end(), branch.half_width_m.begin(), branch.half_width_m.end());
  return half_width_m.empty() ? 0.0 : 2.0 * base::median(std::move(half_width_m));
}

}  // namespace

Centreline trace_centreline(const RoadMesh& road, const CentrelineOptions& options) {
  Mesh mesh = road_only(road);
  if (mesh.triangles.empty()) throw Error("no road found: the mesh has no drivable triangles");
  const RoadGraph graph = road.guide ? RoadGraph{} : road_graph(mesh);
  CentrelineOptions placed = options;
  if (options.start_object && !options.start_near_m) {
    placed.start_near_m = middle_of_object(road.mesh, *options.start_object);
    if (!placed.start_near_m) {
      throw Error(
          fmt::format("no object named '{}' on the drivable surface; give one of its objects as "
                      "start_object, or a point as start_near_m",
                      *options.start_object));
    }
  }
  double width_m = typical_width_m(graph);
  if (road.guide) {
    const RaySurface surface(mesh);
    const RoadWay way = way_along(*road.guide, surface);
    width_m = 2.0 * base::median(way.half_width_m);
    if (width_m == 0.0 && options.guide_width_m)
      return along_guide(way, *options.guide_width_m, options.reverse);
  }
  if (width_m >= kModelWidth_m || width_m < kSmallestWidth_m)
    return trace(mesh, graph, road.guide, placed);

  // A model circuit is traced as large as life, and the line made small again.
  const double enlarged = kUsualWidth_m / width_m;
  mesh.origin_m *= enlarged;
  for (Vector3d& p : mesh.vertices_m) p *= enlarged;
  if (placed.start_near_m) *placed.start_near_m *= enlarged;
  std::optional<Guide> guide = road.guide;
  if (guide)
    for (Vector3d& p : guide->points_m) p *= enlarged;
  Centreline line = trace(mesh, guide ? RoadGraph{} : road_graph(mesh), guide, placed);
  for (Vector3d& p : line.points_m) p /= enlarged;
  for (double& half_m : line.half_width_m) half_m /= enlarged;
  line.length_m /= enlarged;
  return line;
}

bool goes_along(const Centreline& line, const Centreline& other) {
  const std::size_t n = line.points_m.size(), m = other.points_m.size();
  for (std::size_t i = 0; i < n; i += std::max<std::size_t>(1, n / 500)) {
    bool near = false;
    for (std::size_t k = 0; k + (other.closed ? 0 : 1) < m && !near; ++k) {
      const Vector2d a = other.points_m[k].head<2>(), b = other.points_m[(k + 1) % m].head<2>();
      const double t = std::clamp(
          (line.points_m[i].head<2>() - a).dot(b - a) / std::max((b - a).squaredNorm(), 1e-12), 0.0,
          1.0);
      near = (line.points_m[i].head<2>() - a - t * (b - a)).norm() <
             line.half_width_m[i] + other.half_width_m[k];
    }
    if (!near) return false;
  }
  return true;
}

void write_centreline_csv(const Centreline& centreline, const std::string& path) {
  std::string text = "x_m,y_m,z_m,half_width_m\n";
  const auto row = [&](std::size_t i) {
    const Vector3d& p = centreline.points_m[i];
    text += fmt::format("{:.4f},{:.4f},{:.4f},{:.4f}\n", p.x(), p.y(), p.z(),
                        centreline.half_width_m[i]);
  };
  for (std::size_t i = 0; i < centreline.points_m.size(); ++i) row(i);
  if (centreline.closed) row(0);  // a repeated first row says that the line is closed
  base::write_file(path, text);
}

Centreline read_centreline_csv(const std::string& path) {
  const base::CsvTable table = base::read_csv(path, {"x_m", "y_m"}, {"z_m", "half_width_m"});
  Centreline line;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const auto value = [&](std::size_t column) {
      return table.present[column] ? table.value(i, column) : 0.0;
    };
    line.points_m.emplace_back(value(0), value(1), value(2));
    line.half_width_m.push_back(value(3));
    if (!line.points_m.back().allFinite()) {
      throw Error(
          fmt::format("{}: empty or not finite coordinate in row {}; every row needs x_m and y_m",
                      path, i + 2));
    }
  }
  if (line.points_m.size() >= 2 &&
      (line.points_m.front() - line.points_m.back()).head<2>().norm() < 1e-3) {
    line.closed = true;
    line.points_m.pop_back();
    line.half_width_m.pop_back();
  }
  if (line.points_m.size() < 4) {
    throw Error(
        fmt::format("{}: {} stations; a centreline needs at least 4", path, line.points_m.size()));
  }
  line.length_m = curve_length_m(line.points_m, line.closed);
  return line;
}

}  // namespace road
