#include "fork.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <unordered_map>

#include "base/statistics.h"
#include "walk_along.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kAboutAsLong = 0.7;  // of the longest way
constexpr double kWider = 1.2;
constexpr double kAlike = 1.15;          // of two lengths: a longer way round is a detour
constexpr double kNoPartShare = 0.03;    // of the length: an island in the road
constexpr double kLookWidths = 2.0;      // along a branch, to see on which side it leaves
constexpr double kLongestWidths = 20.0;  // of a fork, to each side of the place where it divides
constexpr double kAsUsual = 1.03, kNarrowest = 1.2;
constexpr double kSettledWidths = 2.0;  // no narrower for this long: the fork has ended
constexpr std::size_t kRounds = 3;
constexpr std::ptrdiff_t kAlong = 2;  // stations to both sides, for a direction

/// What one way has and another has not.
struct OwnPart {
  double length_m = 0.0, half_width_m = 0.0;
  Vector3d middle_m = Vector3d::Zero();
};
OwnPart own_part(const RoadGraph& graph, const RoadWay& way, const RoadWay& other) {
  const std::set<std::uint32_t> shared(other.branches.begin(), other.branches.end());
  OwnPart own;
  std::vector<double> half_m;
  for (const std::uint32_t b : way.branches) {
    const RoadBranch& branch = graph.branches[b];
    if (shared.contains(b)) continue;
    own.length_m += branch.length_m;
    half_m.insert(half_m.end(), branch.half_width_m.begin(), branch.half_width_m.end());
    own.middle_m = branch.points_m[branch.points_m.size() / 2];
  }
  if (!half_m.empty()) own.half_width_m = base::median(std::move(half_m));
  return own;
}

/// A place some way along a branch from one of its ends.
Vector2d along(const RoadBranch& branch, bool from_front, double length_m) {
  const std::size_t n = branch.points_m.size();
  double gone_m = 0.0;
  for (std::size_t k = 1; k < n; ++k) {
    const Vector3d &a = branch.points_m[from_front ? k - 1 : n - k],
                   &b = branch.points_m[from_front ? k : n - 1 - k];
    gone_m += (b - a).head<2>().norm();
    if (gone_m >= length_m) return b.head<2>();
  }
  return (from_front ? branch.points_m.back() : branch.points_m.front()).head<2>();
}

/// Indices of stations around one, on a closed walk any number of rounds.
struct Around {
  const Walk& walk;
  std::optional<std::size_t> operator()(std::ptrdiff_t i) const {
    const auto n = static_cast<std::ptrdiff_t>(walk.stations.size());
    if (!walk.closed && (i < 0 || i >= n)) return std::nullopt;
    return static_cast<std::size_t>(((i % n) + n) % n);
  }
};

double usual_width_m(const Walk& walk, std::ptrdiff_t middle, std::ptrdiff_t reach) {
  std::vector<double> widths_m;
  for (std::ptrdiff_t k = -reach; k <= reach; ++k)
    if (const auto i = Around{walk}(middle + k)) widths_m.push_back(walk.stations[*i].width_m());
  return base::median(std::move(widths_m));
}

/// From a fork to one side: the first station where the road is as wide as usual, or no longer gets
/// narrower. Nothing where that is too far.
std::optional<std::ptrdiff_t> end_of_fork(const Walk& walk, const std::vector<double>& width_m,
                                          std::ptrdiff_t from, std::ptrdiff_t sign,
                                          double usual_m) {
  std::ptrdiff_t narrowest = from;
  double gone_m = 0.0, settled_m = 0.0;
  const auto half_round = static_cast<std::ptrdiff_t>(walk.stations.size() / 2);
  for (std::ptrdiff_t k = 0; k < half_round; ++k) {
    const auto i = Around{walk}(from + sign * k), next = Around{walk}(from + sign * (k + 1));
    if (!i || !next) return std::nullopt;
    if (k > 0 && width_m[*i] <= kAsUsual * usual_m) return from + sign * k;
    if (width_m[*i] < 0.99 * width_m[*Around{walk}(narrowest)]) {
      narrowest = from + sign * k;
      settled_m = 0.0;
    }
    const double step_m = (walk.stations[*next].centre - walk.stations[*i].centre).head<2>().norm();
    gone_m += step_m;
    settled_m += step_m;
    if (gone_m > kLongestWidths * usual_m) return std::nullopt;
    if (settled_m > kSettledWidths * usual_m &&
        width_m[*Around{walk}(narrowest)] < kNarrowest * usual_m)
      return narrowest;
  }
  return std::nullopt;
}

/// A fork with the stations that it reaches over, in the order of the walk.
struct Place {
  std::ptrdiff_t begin, end;
  bool on_left;
};

std::size_t nearest_station(const Walk& walk, const Vector2d& p) {
  const auto nearer = [&](const Station& a, const Station& b) {
    return (a.centre.head<2>() - p).squaredNorm() < (b.centre.head<2>() - p).squaredNorm();
  };
  return static_cast<std::size_t>(
      std::min_element(walk.stations.begin(), walk.stations.end(), nearer) - walk.stations.begin());
}

std::optional<Place> place_of(const Fork& fork, const Walk& walk,
                              const std::vector<double>& width_m) {
  const std::size_t nearest = nearest_station(walk, fork.point_m.head<2>());
  const Station& beside = walk.stations[nearest_station(walk, fork.beside_m)];
  const bool on_left = (fork.beside_m - beside.centre.head<2>()).dot(left_of(beside.heading)) > 0.0;
  const double step_m = walk.length_m / static_cast<double>(walk.stations.size());
  const auto reach = static_cast<std::ptrdiff_t>(
      std::min(2.0 * kLongestWidths * walk.stations[nearest].width_m() / step_m,
               0.5 * static_cast<double>(walk.stations.size())));
  const auto at = static_cast<std::ptrdiff_t>(nearest);
  const double usual_m = usual_width_m(walk, at, reach);
  const auto begin = end_of_fork(walk, width_m, at, -1, usual_m),
             end = end_of_fork(walk, width_m, at, 1, usual_m);
  if (!begin || !end || *end - *begin < 2) return std::nullopt;
  return Place{*begin, *end, on_left};
}

/// The nearest place on a way.
Vector2d on_way(const RoadWay& way, const Vector2d& p) {
  const std::size_t n = way.points_m.size();
  Vector2d nearest = way.points_m.front().head<2>();
  for (std::size_t i = 0; i < (way.closed ? n : n - 1); ++i) {
    const Vector2d a = way.points_m[i].head<2>(), b = way.points_m[(i + 1) % n].head<2>();
    const double t =
        std::clamp((p - a).dot(b - a) / std::max((b - a).squaredNorm(), 1e-12), 0.0, 1.0);
    const Vector2d q = a + t * (b - a);
    if ((q - p).squaredNorm() < (nearest - p).squaredNorm()) nearest = q;
  }
  return nearest;
}

void hold(const RaySurface& surface, const RoadWay& way, const Place& place, Walk& walk) {
  const Around around{walk};
  const double first_m = walk.stations[*around(place.begin)].width_m(),
               last_m = walk.stations[*around(place.end)].width_m();
  const double sign = place.on_left ? -1.0 : 1.0;  // of the side that is held
  // The walk may lie between both roads; the way does not.
  for (std::ptrdiff_t i = place.begin + 1; i < place.end; ++i) {
    Vector3d& centre = walk.stations[*around(i)].centre;
    centre.head<2>() = on_way(way, centre.head<2>());
  }
  for (std::size_t round = 0; round < kRounds; ++round) {
    const Walk old = walk;
    for (std::ptrdiff_t i = place.begin + 1; i < place.end; ++i) {
      const double t =
          static_cast<double>(i - place.begin) / static_cast<double>(place.end - place.begin);
      const double half_m = 0.5 * ((1.0 - t) * first_m + t * last_m);
      const Vector3d &before = old.stations[*around(std::max(i - kAlong, place.begin))].centre,
                     &after = old.stations[*around(std::min(i + kAlong, place.end))].centre;
      Station& station = walk.stations[*around(i)];
      station.heading = (after - before).head<2>().normalized();
      const Vector2d normal = left_of(station.heading);
      const Vector3d edge = find_edge(surface, station.centre, sign * normal, kMaxHalfWidth_m);
      const Vector2d middle = edge.head<2>() - sign * half_m * normal;
      const auto hit =
          surface.nearest_hit(middle.x(), middle.y(), station.centre.z(), 2.0 * kLayerReach_m);
      station.centre << middle, hit ? hit->z_m : station.centre.z();
      Vector3d other = station.centre;
      other.head<2>() -= sign * half_m * normal;
      station.left = place.on_left ? other : edge;
      station.right = place.on_left ? edge : other;
    }
  }
}

}  // namespace

base::Answer<RoadWay> main_way(const RoadGraph& graph, const std::vector<RoadWay>& ways) {
  std::size_t best = 0;
  const auto rivals = [&](std::size_t i) {
    const bool shares = std::find_first_of(ways[i].branches.begin(), ways[i].branches.end(),
                                           ways[best].branches.begin(),
                                           ways[best].branches.end()) != ways[i].branches.end();
    return i != best && shares && ways[i].closed == ways[best].closed &&
           ways[i].length_m > kAboutAsLong * ways[0].length_m;
  };
  for (std::size_t i = 1; i < ways.size(); ++i) {
    if (!rivals(i)) continue;
    const OwnPart own = own_part(graph, ways[i], ways[best]),
                  bests = own_part(graph, ways[best], ways[i]);
    if (own.length_m > 0.0 && bests.length_m > 0.0 &&
        own.half_width_m > kWider * bests.half_width_m)
      best = i;
  }
  for (std::size_t i = 0; i < ways.size(); ++i) {
    if (!rivals(i)) continue;
    const OwnPart own = own_part(graph, ways[i], ways[best]),
                  bests = own_part(graph, ways[best], ways[i]);
    const double shorter_m = std::min(own.length_m, bests.length_m),
                 longer_m = std::max(own.length_m, bests.length_m);
    if (shorter_m < kNoPartShare * ways[best].length_m || longer_m > kAlike * shorter_m ||
        own.half_width_m * kWider < bests.half_width_m)
      continue;
    return base::Refusal(fmt::format(
        "the road divides and joins again, and both parts are alike: {:.0f} m long and {:.1f} m "
        "wide by way of ({:.1f}, {:.1f}), {:.0f} m and {:.1f} m by way of ({:.1f}, {:.1f})",
        bests.length_m, 2.0 * bests.half_width_m, bests.middle_m.x(), bests.middle_m.y(),
        own.length_m, 2.0 * own.half_width_m, own.middle_m.x(), own.middle_m.y()));
  }
  return ways[best];
}

std::optional<std::string> two_alike(const std::vector<RoadWay>& ways) {
  const auto text = [](const RoadWay& way) {
    const Vector3d& place = way.points_m.front();
    return fmt::format("{:.0f} m long and {:.1f} m wide at ({:.1f}, {:.1f})", way.length_m,
                       2.0 * base::median(way.half_width_m), place.x(), place.y());
  };
  for (const RoadWay& way : ways) {
    const RoadWay& longest = ways.front();
    const double width = base::median(way.half_width_m) / base::median(longest.half_width_m);
    if (way.closed && longest.closed && longest.length_m < kAlike * way.length_m &&
        std::max(width, 1.0 / width) < kAlike &&
        std::find_first_of(way.branches.begin(), way.branches.end(), longest.branches.begin(),
                           longest.branches.end()) == way.branches.end())
      return fmt::format("two separate roads that are alike: {} and {}", text(longest), text(way));
  }
  return std::nullopt;
}

bool keeps_to(const Walk& walk, const RoadWay& way, double cell_m) {
  const double typical_m = base::median(way.half_width_m);
  const double reach_m = 0.75 * typical_m + cell_m;
  const auto index = [&](double x) { return static_cast<std::int64_t>(std::floor(x / reach_m)); };
  const auto key = [](std::int64_t x, std::int64_t y) { return x << 32 ^ (y & 0xffffffff); };
  std::unordered_map<std::int64_t, std::vector<Vector3d>> near;
  for (const Vector3d& p : way.points_m) near[key(index(p.x()), index(p.y()))].push_back(p);
  return std::all_of(walk.stations.begin(), walk.stations.end(), [&](const Station& station) {
    const Vector3d& c = station.centre;
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy) {
        const auto found = near.find(key(index(c.x()) + dx, index(c.y()) + dy));
        if (found == near.end()) continue;
        for (const Vector3d& p : found->second)
          if ((p - c).head<2>().norm() < reach_m) return true;
      }
    return false;
  });
}

std::vector<Fork> forks_of(const RoadGraph& graph, const RoadWay& way) {
  std::vector<Fork> forks;
  const auto apart_m = [&](const Vector2d& p) { return (on_way(way, p) - p).norm(); };
  for (std::uint32_t v = 0; v < graph.nodes.size(); ++v) {
    const RoadNode& node = graph.nodes[v];
    if (node.branches.size() < 3 || apart_m(node.point_m.head<2>()) > 0.5 * graph.cell_m) continue;
    for (const std::uint32_t b : node.branches) {
      if (graph.branches[b].is_gap) continue;
      const Vector2d beside = along(graph.branches[b], graph.branches[b].from == v,
                                    2.0 * kLookWidths * node.half_width_m);
      if (apart_m(beside) > 0.5 * graph.cell_m) forks.push_back({node.point_m, beside});
    }
  }
  return forks;
}

std::vector<Stretch> hold_through_forks(const RaySurface& surface, const RoadWay& way,
                                        const std::vector<Fork>& forks, Walk& walk) {
  // As measured, or as the walk has it, which keeps a width for a while after a fork.
  std::vector<double> width_m;
  for (const Station& station : walk.stations)
    width_m.push_back(std::max(
        station.width_m(),
        cross_section(surface, station.centre, station.heading, kMaxHalfWidth_m, kMaxHalfWidth_m)
            .width_m()));
  std::vector<Place> places;
  for (const Fork& fork : forks)
    if (const auto place = place_of(fork, walk, width_m)) places.push_back(*place);
  std::vector<Stretch> moved;
  for (const Place& place : places) {
    const bool disputed = std::any_of(places.begin(), places.end(), [&](const Place& other) {
      const auto n = static_cast<std::ptrdiff_t>(walk.stations.size());
      for (const std::ptrdiff_t shift : {-n, std::ptrdiff_t{0}, n})
        if (other.on_left != place.on_left && other.begin + shift < place.end &&
            place.begin < other.end + shift)
          return true;
      return false;
    });
    if (disputed) continue;
    hold(surface, way, place, walk);
    moved.push_back({*Around{walk}(place.begin), *Around{walk}(place.end)});
  }
  return moved;
}

RoadWay straight_through_forks(const RaySurface& surface, const RoadGraph& graph, RoadWay way) {
  const std::vector<Fork> forks = forks_of(graph, way);
  if (forks.empty()) return way;
  Walk walk = walk_along(surface, way);
  const std::vector<Stretch> held = hold_through_forks(surface, way, forks, walk);
  const auto is_held = [&](std::size_t i) {
    return std::any_of(held.begin(), held.end(), [&](const Stretch& stretch) {
      return stretch.begin <= stretch.end ? i >= stretch.begin && i <= stretch.end
                                          : i >= stretch.begin || i <= stretch.end;
    });
  };
  for (Vector3d& p : way.points_m)
    if (const std::size_t i = nearest_station(walk, p.head<2>()); is_held(i))
      p.head<2>() = walk.stations[i].centre.head<2>();
  return way;
}

}  // namespace road
