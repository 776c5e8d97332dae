#include "walk_road.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <unordered_map>

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kBelieveJump_m = 60.0;  // a change of width that lasts this long is one
constexpr double kLost_m = 25.0;         // without either edge

Vector2d rotated(const Vector2d& v, double angle_rad) { return Eigen::Rotation2Dd(angle_rad) * v; }

/// Stations by cell of 4 m, to notice when the walk meets a place where it has been.
class Visited {
 public:
  void add(const Vector3d& centre, std::size_t station) {
    cells_[cell_of(centre.x(), centre.y())].push_back(station);
  }

  /// An earlier station near `centre` that `is_met` takes.
  template <typename IsMet>
  std::optional<std::size_t> find(const Vector3d& centre, const IsMet& is_met) const {
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        const auto found = cells_.find(cell_of(centre.x() + 4.0 * dx, centre.y() + 4.0 * dy));
        if (found == cells_.end()) continue;
        for (const std::size_t other : found->second)
          if (is_met(other)) return other;
      }
    }
    return std::nullopt;
  }

 private:
  static std::int64_t cell_of(double x, double y) {
    return (static_cast<std::int64_t>(std::floor(x / 4.0)) << 32) ^
           (static_cast<std::int64_t>(std::floor(y / 4.0)) & 0xffffffff);
  }
  std::unordered_map<std::int64_t, std::vector<std::size_t>> cells_;
};

/// Rise per metre over the last step of a walk.
double last_slope(const Walk& walk) {
  if (walk.stations.size() < 2) return 0.0;
  const Station &here = walk.stations.back(), &before = walk.stations[walk.stations.size() - 2];
  return (here.centre.z() - before.centre.z()) /
         std::max(0.1, (here.centre - before.centre).head<2>().norm());
}

/// Where a walk goes on.
struct NextPlace {
  Vector2d at;
  double z_m, gone_m;
};

/// The next place with surface ahead of the last station, over gaps; nothing where the road ends.
std::optional<NextPlace> next_place(const RaySurface& surface, const Walk& walk,
                                    const Vector2d& direction, double step_m) {
  const Station& here = walk.stations.back();
  const double slope = last_slope(walk);
  for (double gone_m = step_m; gone_m <= kGapAlong_m; gone_m += step_m) {
    const Vector2d next = here.centre.head<2>() + gone_m * direction;
    const double z_m = here.centre.z() + slope * gone_m;
    if (const auto hit = surface.nearest_hit(next.x(), next.y(), z_m, kLayerReach_m))
      return NextPlace{next, hit->z_m, gone_m};
    // A hole in the middle: look beside it before going on.
    for (const double aside : {-0.25, 0.25}) {
      const Vector2d beside = next + aside * here.width_m() * left_of(direction);
      if (const auto hit = surface.nearest_hit(beside.x(), beside.y(), z_m, kLayerReach_m))
        return NextPlace{beside, hit->z_m, gone_m};
    }
  }
  return std::nullopt;
}

/// The end of an open road: one last station where the surface ends.
void add_end(const RaySurface& surface, const Vector2d& direction, Walk& walk) {
  const Station& here = walk.stations.back();
  const Vector3d end = find_edge(surface, here.centre, direction, kGapAlong_m);
  if ((end - here.centre).head<2>().norm() <= 0.1) return;
  Station last = here;  // a cross-section at the very end would run off it on one side
  last.centre += end - here.centre;
  last.left += end - here.centre;
  last.right += end - here.centre;
  walk.stations.push_back(last);
}

/// How wide the walk takes the road to be.
struct WidthKeeper {
  double half_m, left_astray_m = 0.0, right_astray_m = 0.0;

  /// An edge that jumps is a pit lane, a crossing or a hole: stay where the other edge says the
  /// road is. When the jump lasts, the road has changed its width, and the edge comes in slowly.
  double track(double measured_m, double gone_m, double& astray_m) const {
    const double change_m = measured_m - half_m;
    if (std::abs(change_m) <= 0.4 * gone_m + 0.05) {
      astray_m = 0.0;
      return measured_m;
    }
    astray_m += gone_m;
    return astray_m < kBelieveJump_m ? half_m : half_m + std::copysign(0.1 * gone_m, change_m);
  }

  /// Puts the edges of a station where they are believed to be, square to `normal` through `base`;
  /// false where this is no road.
  bool settle(const Vector2d& base, const Vector2d& normal, double gone_m, Station& station) {
    double left_m = track((station.left.head<2>() - base).dot(normal), gone_m, left_astray_m);
    double right_m = track(-(station.right.head<2>() - base).dot(normal), gone_m, right_astray_m);
    if (std::min(left_astray_m, right_astray_m) > kLost_m) return false;  // no edge in sight
    // One edge held at its old distance from a predicted middle would let the line drift: keep the
    // width.
    if (left_astray_m > 0.0 && right_astray_m == 0.0 && left_astray_m < kBelieveJump_m)
      left_m = 2.0 * half_m - right_m;
    if (right_astray_m > 0.0 && left_astray_m == 0.0 && right_astray_m < kBelieveJump_m)
      right_m = 2.0 * half_m - left_m;
    half_m = 0.5 * (left_m + right_m);
    if (2.0 * half_m < kMinWidth_m) return false;
    station.left.head<2>() = base + left_m * normal;
    station.right.head<2>() = base - right_m * normal;
    station.centre.head<2>() = 0.5 * (station.left + station.right).head<2>();
    return true;
  }
};

/// Whether a walk that arrives at `centre` along `heading` meets a station of its own, going the
/// same way on the same layer.
bool meets(const Vector3d& centre, const Vector2d& heading, const Station& old, double step_m) {
  const Vector2d d = (centre - old.centre).head<2>();
  return d.dot(old.heading) >= 0.0 && d.dot(old.heading) < 2.0 * step_m &&
         std::abs(d.dot(left_of(old.heading))) < 0.25 * old.width_m() &&
         std::abs(centre.z() - old.centre.z()) < 1.5 && heading.dot(old.heading) > 0.5;
}

/// Closes the walk at the station that it has met, unless the loop is so short that the walk was
/// turning on the spot, lost on a wide surface.
void close_at(std::size_t met, Walk& walk) {
  double loop_m = 0.0;
  for (std::size_t i = met; i + 1 < walk.stations.size(); ++i)
    loop_m += (walk.stations[i + 1].centre - walk.stations[i].centre).head<2>().norm();
  if (loop_m < 10.0 * walk.stations.back().width_m()) return;
  walk.stations.erase(walk.stations.begin(),
                      walk.stations.begin() + static_cast<std::ptrdiff_t>(met));
  walk.closed = true;
}

/// Goes forward from `start` until the road ends or meets itself.
Walk walk_forward(const RaySurface& surface, const Station& start) {
  Walk walk;
  walk.stations.push_back(start);
  Vector2d segment = start.heading;
  double turn_rad = 0.0;
  WidthKeeper width{0.5 * start.width_m()};
  Visited visited;
  visited.add(start.centre, 0);

  constexpr std::size_t kMaxStations = 200'000;
  while (walk.stations.size() < kMaxStations) {
    const Station& here = walk.stations.back();
    const double step_m = std::clamp(here.width_m() / 5.0, 0.5, 2.0);
    const Vector2d direction = rotated(segment, turn_rad);
    const std::optional<NextPlace> next = next_place(surface, walk, direction, step_m);
    if (!next) {
      add_end(surface, direction, walk);
      break;
    }
    const Vector2d heading = rotated(direction, 0.5 * turn_rad);
    const double reach_m = 2.0 * width.half_m + 2.0;
    Station station =
        cross_section(surface, {next->at.x(), next->at.y(), next->z_m}, heading, reach_m, reach_m);
    const Vector2d base = here.centre.head<2>() + next->gone_m * direction;
    if (!width.settle(base, left_of(heading), next->gone_m, station)) break;

    const Vector2d chord = (station.centre - here.centre).head<2>();
    if (chord.norm() < 0.2 * step_m) break;
    const Vector2d new_segment = chord.normalized();
    // The inner edge still has a radius.
    const double sharpest_rad = chord.norm() / (1.1 * width.half_m);
    const double turned_rad = angle_between(segment, new_segment);
    turn_rad = std::clamp(0.5 * (turn_rad + turned_rad), -sharpest_rad,
                          sharpest_rad);  // damped: holes make it jump
    segment = new_segment;

    const std::size_t index = walk.stations.size();
    const auto met = visited.find(station.centre, [&](std::size_t other) {
      return index - other > 15 && meets(station.centre, segment, walk.stations[other], step_m);
    });
    if (met) {
      close_at(*met, walk);
      break;
    }
    station.heading = segment;
    visited.add(station.centre, index);
    walk.stations.push_back(station);
  }
  return walk;
}

/// A place to start: the narrowest direction across the surface at a point is the cross-section.
std::optional<Station> seed_station(const RaySurface& surface, const Vector3d& p) {
  constexpr int kDirections = 24;
  std::optional<Station> best;
  double best_width_m = kMaxWidth_m;
  Vector3d at = p;
  for (int round = 0; round < 2; ++round) {
    for (int i = 0; i < kDirections; ++i) {
      const double angle = std::numbers::pi * i / kDirections;
      const Station station = cross_section(surface, at, {std::cos(angle), std::sin(angle)});
      if (station.width_m() < best_width_m) {
        best_width_m = station.width_m();
        best = station;
      }
    }
    if (!best || best_width_m < kMinWidth_m) return std::nullopt;
    at = best->centre;
  }
  return best;
}

Walk walk_from(const RaySurface& surface, const Station& seed) {
  Walk walk = walk_forward(surface, seed);
  if (!walk.closed) {
    // Not from the seed itself: near the end of a road its narrowest direction is no cross-section.
    const std::size_t turn_at = std::min<std::size_t>(20, walk.stations.size() / 2);
    Station back = walk.stations[turn_at];
    back.heading = -back.heading;
    std::swap(back.left, back.right);
    Walk behind = walk_forward(surface, back);
    if (behind.closed) {
      walk = std::move(behind);
    } else {
      std::reverse(behind.stations.begin(), behind.stations.end());
      for (Station& station : behind.stations) {
        station.heading = -station.heading;
        std::swap(station.left, station.right);
      }
      behind.stations.pop_back();  // the station where both begin
      behind.stations.insert(behind.stations.end(),
                             walk.stations.begin() + static_cast<std::ptrdiff_t>(turn_at),
                             walk.stations.end());
      walk.stations = std::move(behind.stations);
    }
  }
  measure(walk);
  return walk;
}

double horizontal_area_m2(const Mesh& mesh) {
  double area = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vector3d a = mesh.vertex(t, 1) - mesh.vertex(t, 0);
    const Vector3d b = mesh.vertex(t, 2) - mesh.vertex(t, 0);
    area += 0.5 * std::abs(a.x() * b.y() - a.y() * b.x());
  }
  return area;
}

bool passes_near(const Walk& walk, const Vector3d& p) {
  return std::any_of(walk.stations.begin(), walk.stations.end(), [&](const Station& s) {
    return (s.centre - p).head<2>().norm() < s.width_m() && std::abs(s.centre.z() - p.z()) < 2.0;
  });
}

}  // namespace

std::string describe(const Walk& walk) {
  const Vector3d& p = walk.stations.front().centre;
  return fmt::format("{} of {:.0f} m through x = {:.1f}, y = {:.1f}",
                     walk.closed ? "a loop" : "an open road", walk.length_m, p.x(), p.y());
}

base::Answer<Walk> walk_road(const Mesh& mesh, const RaySurface& surface,
                             const CentrelineOptions& options) {
  constexpr std::size_t kSeeds = 24;
  const double area_m2 = horizontal_area_m2(mesh);
  std::vector<Walk> walks;
  const std::size_t stride = std::max<std::size_t>(1, mesh.triangles.size() / kSeeds);
  double covered_m2 = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size() && covered_m2 < 0.9 * area_m2; t += stride) {
    const Vector3d p =
        mesh.origin_m + (mesh.vertex(t, 0) + mesh.vertex(t, 1) + mesh.vertex(t, 2)) / 3.0;
    if (std::any_of(walks.begin(), walks.end(), [&](const Walk& w) { return passes_near(w, p); }))
      continue;
    const auto seed = seed_station(surface, p);
    if (!seed) continue;
    Walk walk = walk_from(surface, *seed);
    if (walk.stations.size() < 8 || walk.length_m < 3.0 * seed->width_m()) continue;
    covered_m2 += walk.area_m2;
    walks.push_back(std::move(walk));
  }
  // What runs along the rim of a wide surface is no road on it.
  std::erase_if(walks, [&](const Walk& walk) { return walk.area_m2 < 0.1 * area_m2; });
  if (walks.empty()) {
    return base::Refusal(fmt::format(
        "no road found: none of the {:.0f} m2 of road surface forms a strip {:.0f} to {:.0f} m "
        "wide; check the "
        "unit and the up axis (--unit, --up) and which objects count as road (name_rules)",
        area_m2, kMinWidth_m, kMaxWidth_m));
  }
  if (options.start_near_m) {
    // Where several roads exist, the wanted one passes near the wanted start.
    const auto distance = [&](const Walk& walk) {
      double best = std::numeric_limits<double>::infinity();
      for (const Station& s : walk.stations)
        best = std::min(best, (s.centre.head<2>() - *options.start_near_m).norm());
      return best;
    };
    return *std::min_element(walks.begin(), walks.end(), [&](const Walk& a, const Walk& b) {
      return distance(a) < distance(b);
    });
  }
  std::stable_sort(walks.begin(), walks.end(), [](const Walk& a, const Walk& b) {
    if (a.closed != b.closed) return a.closed;
    return a.length_m > b.length_m;
  });
  if (walks.size() > 1 && walks[1].closed == walks[0].closed &&
      walks[1].length_m > 0.5 * walks[0].length_m) {
    return base::Refusal(fmt::format(
        "two separate roads: {} and {}; choose one with --start-at X,Y (recipe: start_near_m)",
        describe(walks[0]), describe(walks[1])));
  }
  return walks[0];
}

}  // namespace road
