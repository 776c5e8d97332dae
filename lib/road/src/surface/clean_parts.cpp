#include "clean_parts.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "cleaning.h"
#include "mesh/ray_surface.h"
#include "strip_ends.h"

namespace road {
namespace {

// A second component with this share of the largest one's road is another circuit, not a leftover.
constexpr double kOtherCircuitShare = 0.3;
// A piece with less than this is a leftover, whatever its ends face.
constexpr double kPieceShare = 0.01;
// Two components whose corners lie this near, as a share of their size, are one road drawn twice
// where this share of the one lies over or under the other. Carriageways side by side do not.
constexpr double kSameRoadShare = 0.02, kOverOther = 0.5;
constexpr std::size_t kPlacesOnPart = 200;  // triangles of one of them
constexpr double kWidestEnd_m = 60.0;       // of a road, along its border

/// Components of the surface where borders that touch without shared vertices count as joined.
Components touching_components(const Soup& soup, CleanReport& facts) {
  Components found = components(soup.triangles);
  facts.components = found.count;
  facts.non_manifold_edges = found.at_non_manifold_edges.size();
  if (found.count < 2) return found;

  // Border edges in a coarse grid; every border vertex looks for edges of other components nearby.
  struct Edge {
    std::uint32_t a, b, component;
  };
  std::vector<Edge> edges;
  const std::vector<EdgeUse> uses = edge_uses(soup.triangles);
  for (std::size_t i = 0; i < uses.size(); ++i) {
    if ((i > 0 && uses[i - 1].key == uses[i].key) ||
        (i + 1 < uses.size() && uses[i + 1].key == uses[i].key))
      continue;
    edges.push_back({static_cast<std::uint32_t>(uses[i].key >> 32),
                     static_cast<std::uint32_t>(uses[i].key), found.of_triangle[uses[i].t]});
  }
  constexpr double kCell_m = 4.0;
  const auto cell_of = [](double value) {
    return static_cast<std::int64_t>(std::floor(value / kCell_m));
  };
  const auto key_of = [](std::int64_t x, std::int64_t y) {
    return static_cast<std::uint64_t>(x) << 32 ^ static_cast<std::uint32_t>(y);
  };
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells;
  for (std::uint32_t e = 0; e < edges.size(); ++e) {
    const Eigen::Vector3d &p = soup.vertices_m[edges[e].a], &q = soup.vertices_m[edges[e].b];
    const int steps = 1 + static_cast<int>((q - p).head<2>().norm() / kCell_m * 2.0);
    std::uint64_t last = 0;
    for (int k = 0; k <= steps; ++k) {
      const Eigen::Vector3d at = p + (q - p) * (static_cast<double>(k) / steps);
      const std::uint64_t key = key_of(cell_of(at.x()), cell_of(at.y()));
      if (k == 0 || key != last) cells[key].push_back(e);
      last = key;
    }
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> touches;
  for (const Edge& edge : edges) {
    const Eigen::Vector3d& v = soup.vertices_m[edge.a];
    std::uint32_t counted = kNoIndex;
    for (std::int64_t x = cell_of(v.x() - kTouch_m); x <= cell_of(v.x() + kTouch_m); ++x) {
      for (std::int64_t y = cell_of(v.y() - kTouch_m); y <= cell_of(v.y() + kTouch_m); ++y) {
        const auto cell = cells.find(key_of(x, y));
        if (cell == cells.end()) continue;
        for (const std::uint32_t e : cell->second) {
          if (edges[e].component == edge.component || edges[e].component == counted) continue;
          const Eigen::Vector3d &p = soup.vertices_m[edges[e].a], &q = soup.vertices_m[edges[e].b];
          const double s = std::clamp((v - p).dot(q - p) / (q - p).squaredNorm(), 0.0, 1.0);
          if ((p + s * (q - p) - v).norm() > kTouch_m) continue;
          counted = edges[e].component;
          ++touches[std::minmax(edge.component, edges[e].component)];
        }
      }
    }
  }
  DisjointSets sets(found.count);
  for (const auto& [pair, count] : touches) {
    if (count >= 2) sets.join(pair.first, pair.second);
  }
  for (std::uint32_t& n : found.of_triangle) n = sets.find(n);
  return found;
}

/// What a bridge and the roads at its two ends belong to becomes one component.
void join_by_bridges(const Soup& soup, const std::vector<Bridge>& bridges,
                     std::vector<std::uint32_t>& component) {
  for (const Bridge& bridge : bridges) {
    std::array<double, 2> nearest_m{std::numeric_limits<double>::infinity(),
                                    std::numeric_limits<double>::infinity()};
    std::array<std::uint32_t, 2> at{kNoIndex, kNoIndex};
    std::vector<std::uint32_t> together;
    for (std::uint32_t i = 0; i < soup.triangles.size(); ++i) {
      if (soup.surface_class[i] != SurfaceClass::road) continue;
      if (std::binary_search(bridge.triangles.begin(), bridge.triangles.end(), soup.source[i])) {
        together.push_back(component[i]);
        continue;
      }
      for (std::size_t end = 0; end < 2; ++end) {
        for (const std::uint32_t vertex : soup.triangles[i]) {
          const double d = (soup.vertices_m[vertex] - (end == 0 ? bridge.p : bridge.q)).norm();
          if (d < nearest_m[end]) nearest_m[end] = d, at[end] = component[i];
        }
      }
    }
    for (const std::uint32_t c : at)
      if (c != kNoIndex) together.push_back(c);
    if (together.empty()) continue;
    const std::uint32_t one = *std::min_element(together.begin(), together.end());
    for (std::uint32_t& c : component)
      if (std::find(together.begin(), together.end(), c) != together.end()) c = one;
  }
}

/// Pieces of road whose ends face each other over a gap that may be bridged are one road.
void join_facing_ends(const Soup& soup, std::vector<std::uint32_t>& component) {
  std::map<std::uint32_t, double> road_m2;
  std::vector<std::uint32_t> component_at(soup.vertices_m.size(), kNoIndex);
  for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
    if (soup.surface_class[i] != SurfaceClass::road) continue;
    road_m2[component[i]] += soup.area_vector_of(i).norm();
    for (const std::uint32_t vertex : soup.triangles[i]) component_at[vertex] = component[i];
  }
  double largest_m2 = 0.0;
  for (const auto& [number, m2] : road_m2) largest_m2 = std::max(largest_m2, m2);
  std::erase_if(road_m2, [&](const auto& part) { return part.second < kPieceShare * largest_m2; });
  if (road_m2.size() < 2) return;
  DisjointSets sets(1 + *std::max_element(component.begin(), component.end()));
  for (const Gap& gap :
       facing_ends(open_ends(road_triangles(soup), soup.vertices_m, kWidestEnd_m), kRoadGap_m)) {
    const std::uint32_t a = component_at[gap.a.vertices[0]], b = component_at[gap.b.vertices[0]];
    if (road_m2.contains(a) && road_m2.contains(b)) sets.join(a, b);
  }
  for (std::uint32_t& c : component) c = sets.find(c);
}

/// Keeps the components of which `keep` says so by any of their triangles.
template <class Keep>
void keep_where(Soup& soup, const Components& found, CleanReport& facts, Keep keep) {
  const auto& edges = found.at_non_manifold_edges;
  facts.non_manifold_edges =
      static_cast<std::size_t>(std::count_if(edges.begin(), edges.end(), keep));
  soup.filter([&](std::size_t i) {
    if (keep(i)) return true;
    ++facts.dropped["not connected"];
    return false;
  });
}

}  // namespace

void keep_what_touches_road(Soup& soup, CleanReport& facts) {
  const Components found = touching_components(soup, facts);
  const std::vector<std::uint32_t>& component = found.of_triangle;
  std::unordered_set<std::uint32_t> with_road;
  for (std::size_t i = 0; i < soup.triangles.size(); ++i)
    if (soup.surface_class[i] == SurfaceClass::road) with_road.insert(component[i]);
  keep_where(soup, found, facts, [&](std::size_t i) { return with_road.contains(component[i]); });
}

namespace {

/// A component of the surface with its road.
struct Part {
  double road_m2 = 0.0, height_m3 = 0.0;  // the sum of area times height
  double mean_height_m() const { return height_m3 / road_m2; }
  double distance_m = std::numeric_limits<double>::infinity();
  Eigen::Vector3d lowest = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d highest = -lowest;
  std::vector<std::uint32_t> triangles;
  Eigen::Vector3d centre() const { return (lowest + highest) / 2.0; }
};

std::map<std::uint32_t, Part> parts_of(const Soup& soup,
                                       const std::vector<std::uint32_t>& component,
                                       const Eigen::Vector3d& origin_m,
                                       const std::optional<Eigen::Vector2d>& near_m) {
  std::map<std::uint32_t, Part> parts;
  for (std::uint32_t i = 0; i < soup.triangles.size(); ++i) {
    if (soup.surface_class[i] != SurfaceClass::road) continue;
    Part& part = parts[component[i]];
    part.triangles.push_back(i);
    const double area_m2 = soup.area_vector_of(i).norm();
    part.road_m2 += area_m2;
    for (const std::uint32_t vertex : soup.triangles[i]) {
      const Eigen::Vector3d& v = soup.vertices_m[vertex];
      part.height_m3 += area_m2 * v.z() / 3.0;
      part.lowest = part.lowest.cwiseMin(v);
      part.highest = part.highest.cwiseMax(v);
      if (near_m)
        part.distance_m = std::min(part.distance_m, ((origin_m + v).head<2>() - *near_m).norm());
    }
  }
  return parts;
}

/// Whether two parts are one road drawn twice.
bool same_road(const Soup& soup, const Part& a, const Part& b) {
  if (&a == &b) return true;
  const double apart_m = (a.lowest - b.lowest).norm() + (a.highest - b.highest).norm();
  if (apart_m >= kSameRoadShare * (b.highest - b.lowest).norm()) return false;
  Mesh other;
  other.vertices_m = soup.vertices_m;
  for (const std::uint32_t i : b.triangles) other.triangles.push_back(soup.triangles[i]);
  const RaySurface rays(other);
  std::size_t over = 0, all = 0;
  for (std::size_t k = 0; k < a.triangles.size();
       k += 1 + a.triangles.size() / kPlacesOnPart, ++all) {
    const Triangle& t = soup.triangles[a.triangles[k]];
    const Eigen::Vector3d at =
        (soup.vertices_m[t[0]] + soup.vertices_m[t[1]] + soup.vertices_m[t[2]]) / 3.0;
    over += rays.all_hits(at.x(), at.y()).empty() ? 0 : 1;
  }
  return static_cast<double>(over) > kOverOther * static_cast<double>(all);
}

}  // namespace

std::optional<base::Refusal> keep_one_circuit(Soup& soup, const std::vector<Bridge>& bridges,
                                              const Eigen::Vector3d& origin_m,
                                              const CleanOptions& options, CleanReport& facts) {
  Components found = touching_components(soup, facts);
  std::vector<std::uint32_t>& component = found.of_triangle;
  join_by_bridges(soup, bridges, component);
  join_facing_ends(soup, component);
  const std::map<std::uint32_t, Part> parts = parts_of(soup, component, origin_m, options.near_m);
  if (parts.empty()) return std::nullopt;
  auto chosen = parts.begin();
  for (auto part = parts.begin(); part != parts.end(); ++part) {
    if (part->second.road_m2 > chosen->second.road_m2) chosen = part;
  }
  // Of one road drawn twice a wheel meets the upper one.
  for (auto part = parts.begin(); part != parts.end(); ++part)
    if (part->second.road_m2 >= kOtherCircuitShare * chosen->second.road_m2 &&
        same_road(soup, chosen->second, part->second) &&
        part->second.mean_height_m() > chosen->second.mean_height_m())
      chosen = part;
  std::vector<const Part*> circuits;
  for (const auto& [number, part] : parts) {
    // One road drawn twice is one road.
    const auto is_this = [&, &part = part](const Part* other) {
      return same_road(soup, *other, part);
    };
    if (part.road_m2 >= kOtherCircuitShare * chosen->second.road_m2 &&
        std::none_of(circuits.begin(), circuits.end(), is_this))
      circuits.push_back(&part);
  }
  if (circuits.size() > 1 && !options.near_m) {
    std::string places;
    for (const Part* part : circuits) {
      const Eigen::Vector3d centre = origin_m + part->centre();
      const Eigen::Vector3d size = part->highest - part->lowest;
      places += fmt::format("{}{:.0f} m2 around ({:.0f}, {:.0f}), {:.0f} x {:.0f} m",
                            places.empty() ? "" : "; ", part->road_m2, centre.x(), centre.y(),
                            size.x(), size.y());
    }
    return base::Refusal(
        fmt::format("{} separate roads of similar size: {}; wanted one, near a point (--near-m "
                    "X,Y, near_m in a recipe)",
                    circuits.size(), places));
  }
  if (options.near_m) {
    for (auto part = parts.begin(); part != parts.end(); ++part) {
      const bool circuit =
          std::find(circuits.begin(), circuits.end(), &part->second) != circuits.end();
      if (circuit && part->second.distance_m < chosen->second.distance_m) chosen = part;
    }
  }
  keep_where(soup, found, facts, [&](std::size_t i) { return component[i] == chosen->first; });
  return std::nullopt;
}

}  // namespace road
