#include "road/centreline.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "base/statistics.h"
#include "border_curve.h"
#include "borders.h"
#include "find_road.h"
#include "fork.h"
#include "guide_rows.h"
#include "middles.h"
#include "road/road_graph.h"
#include "start_of_line.h"
#include "stations.h"
#include "walk_road.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSmallestWidth_m = 0.2;

constexpr double kUnlike = 0.3;  // of half the width, along a guide

constexpr double kUnlikeHeld = 0.03;  // and where one edge is known to be the other road's

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

double signed_area_m2(const std::vector<Vector3d>& points) {
  double area = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d &a = points[i], &b = points[(i + 1) % points.size()];
    area += 0.5 * ((a.x() - points[0].x()) * (b.y() - points[0].y()) -
                   (b.x() - points[0].x()) * (a.y() - points[0].y()));
  }
  return area;
}

/// A walk with what is known of its stations.
struct MeasuredWalk {
  Walk walk;
  std::vector<double> station_s_m;  // along it
  std::vector<Stretch> held;        // where a fork left one edge to trust
  bool guided = false;

  bool is_held(double s_m) const {
    return std::any_of(held.begin(), held.end(), [&](const Stretch& stretch) {
      const double begin_m = station_s_m[stretch.begin], end_m = station_s_m[stretch.end];
      return begin_m <= end_m ? s_m >= begin_m && s_m <= end_m : s_m >= begin_m || s_m <= end_m;
    });
  }
  Middle middle_at(std::size_t station) const {
    return {station_s_m[station], walk.stations[station].centre,
            0.5 * walk.stations[station].width_m()};
  }
};

/// The middles that the mesh's borders tell, without those of other roads.
std::vector<Middle> middles_of_borders(const Mesh& mesh, const RaySurface& surface,
                                       const MeasuredWalk& measured) {
  auto [left, right] = borders_along(mesh, measured.walk, measured.station_s_m);
  if (left.size() < 4 || right.size() < 4) return {};
  const BorderCurve left_curve(std::move(left), measured.walk.closed);
  const BorderCurve right_curve(std::move(right), measured.walk.closed);
  std::vector<Middle> middles =
      middles_between(surface, measured.walk, left_curve, right_curve, measured.station_s_m);
  std::erase_if(middles, [&](const Middle& m) {
    const bool held_here = measured.is_held(m.s_m);
    return (measured.guided || held_here) &&
           !agrees(m, measured.walk, measured.station_s_m, held_here ? kUnlikeHeld : kUnlike);
  });
  return middles;
}

/// Where the mesh's border told too little, the walk itself fills in.
std::vector<Middle> filled_in(const std::vector<Middle>& middles, const MeasuredWalk& measured) {
  const std::vector<double>& station_s_m = measured.station_s_m;
  const bool closed = measured.walk.closed;
  std::vector<Middle> complete;
  const auto fill = [&](double from_m, double to_m) {
    for (std::size_t i = 0; i < measured.walk.stations.size(); ++i) {
      const double longest_bare_m =
          measured.guided || measured.is_held(station_s_m[i]) ? 10.0 : 40.0;
      if (to_m - from_m >= longest_bare_m && station_s_m[i] > from_m + 1.0 &&
          station_s_m[i] < to_m - 1.0)
        complete.push_back(measured.middle_at(i));
    }
  };
  double last_m = closed && !middles.empty() ? middles.back().s_m - station_s_m.back() : 0.0;
  for (const Middle& m : middles) {
    fill(std::max(last_m, -1.1), m.s_m);
    complete.push_back(m);
    last_m = m.s_m;
  }
  if (closed && !middles.empty()) return complete;
  fill(last_m - (middles.empty() ? 1.1 : 0.0), station_s_m.back() + 1.1);
  // An open road ends where the surface ends, not at the last ring that both edges share.
  if (!closed && !complete.empty()) {
    if (complete.front().s_m > 0.5) complete.insert(complete.begin(), measured.middle_at(0));
    if (complete.back().s_m < station_s_m.back() - 0.5)
      complete.push_back(measured.middle_at(station_s_m.size() - 1));
  }
  return complete;
}

/// Counter-clockwise unless asked otherwise; an open road keeps the order of its walk's longer
/// axis. A guide is followed.
void set_direction(Centreline& line, bool guided, bool reverse) {
  const bool backwards = guided ? false
                         : line.closed
                             ? signed_area_m2(line.points_m) < 0.0
                             : (line.points_m.back() - line.points_m.front()).head<2>().sum() < 0.0;
  if (backwards == reverse) return;
  std::reverse(line.points_m.begin(), line.points_m.end());
  std::reverse(line.half_width_m.begin(), line.half_width_m.end());
}

base::Answer<Centreline> trace(const Mesh& mesh, const RoadGraph& graph,
                               const std::optional<Guide>& guide,
                               const CentrelineOptions& options) {
  const RaySurface surface(mesh);
  MeasuredWalk measured;
  measured.guided = guide.has_value();
  auto walk = find_road(mesh, surface, graph, guide, options);
  if (!walk) return walk.refusal();
  measured.walk = *std::move(walk);
  refine(surface, measured.walk);
  measure(measured.walk);
  if (!guide && measured.walk.closed) {
    const auto way = closed_way(graph, options);
    if (!way) return way.refusal();
    if (*way) {
      measured.held = hold_through_forks(surface, **way, forks_of(graph, **way), measured.walk);
      measure(measured.walk);
    }
  }
  measured.station_s_m = places_along(measured.walk);

  Centreline line;
  line.closed = measured.walk.closed;
  for (const Middle& m : filled_in(middles_of_borders(mesh, surface, measured), measured)) {
    line.points_m.push_back(m.point);
    line.half_width_m.push_back(m.half_width_m);
  }
  if (line.points_m.size() < 4)
    return base::Refusal(fmt::format("the road found is too short: {}", describe(measured.walk)));

  set_direction(line, measured.guided, options.reverse);
  if (line.closed) {
    if (options.start_near_m) {
      start_at(line, *options.start_near_m);
    } else if (guide) {
      start_at(line, guide->points_m.front().head<2>());
    } else {
      rotate_to(line, middle_of_longest_straight(line.points_m));
    }
  } else {
    draw_in_ends(surface, line);
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

base::Answer<Centreline> try_trace_centreline(const RoadMesh& road,
                                              const CentrelineOptions& options) {
  Mesh mesh = road_only(road);
  if (mesh.triangles.empty())
    return base::Refusal("no road found: the mesh has no drivable triangles");
  const RoadGraph graph = road.guide ? RoadGraph{} : road_graph(mesh);
  double width_m = typical_width_m(graph);
  if (road.guide) {
    const RaySurface surface(mesh);
    const RoadWay way = way_along(*road.guide, surface);
    width_m = 2.0 * base::median(way.half_width_m);
    if (width_m == 0.0 && options.guide_width_m)
      return along_guide(way, *options.guide_width_m, options.reverse);
  }
  if (width_m >= kModelWidth_m || width_m < kSmallestWidth_m)
    return trace(mesh, graph, road.guide, options);

  // A model circuit is traced as large as life, and the line made small again.
  const double enlarged = kUsualWidth_m / width_m;
  mesh.origin_m *= enlarged;
  for (Vector3d& p : mesh.vertices_m) p *= enlarged;
  CentrelineOptions placed = options;
  if (placed.start_near_m) *placed.start_near_m *= enlarged;
  std::optional<Guide> guide = road.guide;
  if (guide)
    for (Vector3d& p : guide->points_m) p *= enlarged;
  auto line = trace(mesh, guide ? RoadGraph{} : road_graph(mesh), guide, placed);
  if (!line) return line;
  for (Vector3d& p : line->points_m) p /= enlarged;
  for (double& half_m : line->half_width_m) half_m /= enlarged;
  line->length_m /= enlarged;
  return line;
}

Centreline trace_centreline(const RoadMesh& road, const CentrelineOptions& options) {
  return try_trace_centreline(road, options).or_throw();
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

}  // namespace road
