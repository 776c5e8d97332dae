#include "corner_holes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "clean_classes.h"
#include "mesh_topology.h"

namespace road {
namespace {

/// A border of three or four edges, surface on the right: counter-clockwise in plan. Or a notch:
/// three corners whose last edge is none of the surface's.
struct CornerHole {
  std::vector<std::uint32_t> corners;
  std::vector<std::uint32_t> across;  ///< the triangle beyond the edge from corner k to the next
  bool is_notch() const { return across.size() < corners.size(); }
};

/// Border edges of a surface by the corner that they start from, surface on the right.
class Borders {
 public:
  explicit Borders(const std::vector<Triangle>& triangles) {
    const std::vector<EdgeUse> uses = edge_uses(triangles);
    for (std::size_t i = 0; i < uses.size(); ++i) {
      if ((i > 0 && uses[i - 1].key == uses[i].key) ||
          (i + 1 < uses.size() && uses[i + 1].key == uses[i].key))
        continue;
      const Triangle& t = triangles[uses[i].t];
      const std::uint32_t from = t[(uses[i].c + 1U) % 3], to = t[uses[i].c];
      ends_[from].push_back(to);
      triangle_[directed(from, to)] = uses[i].t;
      starts_.push_back(from);
    }
    std::sort(starts_.begin(), starts_.end());
    starts_.erase(std::unique(starts_.begin(), starts_.end()), starts_.end());
    for (auto& [from, to] : ends_) std::sort(to.begin(), to.end());
  }

  /// Each border of `count` edges once, from its lowest corner on, in their order.
  std::vector<CornerHole> of(std::size_t count) const {
    std::vector<CornerHole> found;
    std::vector<std::uint32_t> way;
    for (const std::uint32_t start : starts_) {
      way.assign(1, start);
      go_on(way, count, found);
    }
    return found;
  }

  /// Each corner of a border with the next two, where the three make no hole.
  std::vector<CornerHole> notches() const {
    std::vector<CornerHole> found;
    for (const std::uint32_t a : starts_)
      for (const std::uint32_t b : ends_.at(a)) {
        const auto ends = ends_.find(b);
        if (ends == ends_.end()) continue;
        for (const std::uint32_t c : ends->second)
          if (c != a && !triangle_.contains(directed(c, a)))
            found.push_back(
                {{a, b, c}, {triangle_.at(directed(a, b)), triangle_.at(directed(b, c))}});
      }
    return found;
  }

 private:
  void go_on(std::vector<std::uint32_t>& way, std::size_t count,
             std::vector<CornerHole>& found) const {
    const auto ends = ends_.find(way.back());
    if (ends == ends_.end()) return;
    for (const std::uint32_t to : ends->second) {
      if (way.size() == count && to == way.front()) {
        CornerHole hole{way, {}};
        for (std::size_t k = 0; k < count; ++k)
          hole.across.push_back(triangle_.at(directed(way[k], way[(k + 1) % count])));
        found.push_back(std::move(hole));
      }
      if (way.size() == count || to <= way.front() ||
          std::find(way.begin(), way.end(), to) != way.end())
        continue;
      way.push_back(to);
      go_on(way, count, found);
      way.pop_back();
    }
  }

  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> ends_;
  std::unordered_map<std::uint64_t, std::uint32_t> triangle_;
  std::vector<std::uint32_t> starts_;
};

/// A triangle that closes a hole or half of it, and the triangle beside it that it is like.
struct Closing {
  Triangle triangle;
  std::uint32_t like;
};

double longest_side_m(const Soup& soup, const CornerHole& hole) {
  double longest_m = 0.0;
  for (std::size_t k = 0; k < hole.corners.size(); ++k)
    longest_m = std::max(longest_m, (soup.vertices_m[hole.corners[k]] -
                                     soup.vertices_m[hole.corners[(k + 1) % hole.corners.size()]])
                                        .norm());
  return longest_m;
}

bool is_flat(const Soup& soup, const Triangle& t, double steepest_z) {
  const Eigen::Vector3d area =
      area_vector(soup.vertices_m[t[0]], soup.vertices_m[t[1]], soup.vertices_m[t[2]]);
  return area.norm() > kZeroArea_m2 && area.z() >= steepest_z * area.norm();
}

/// The class that most of these triangles have, road before others.
std::uint32_t most_like(const Soup& soup, const std::vector<std::uint32_t>& triangles) {
  std::uint32_t best = triangles.front();
  std::size_t most = 0;
  for (const std::uint32_t t : triangles) {
    const auto same = static_cast<std::size_t>(std::count_if(
        triangles.begin(), triangles.end(),
        [&](std::uint32_t other) { return soup.surface_class[other] == soup.surface_class[t]; }));
    const bool is_road = soup.surface_class[t] == SurfaceClass::road;
    if (same > most || (same == most && is_road)) best = t, most = same;
  }
  return best;
}

/// Whether a hole is one of the road: at least one road or kerb lies across an edge of it, at all
/// edges of a notch. What is missing of the verge stays so.
bool is_of_road(const Soup& soup, const CornerHole& hole) {
  const auto driven = std::count_if(hole.across.begin(), hole.across.end(), [&](std::uint32_t t) {
    return soup.surface_class[t] == SurfaceClass::road ||
           soup.surface_class[t] == SurfaceClass::kerb;
  });
  return hole.is_notch() ? driven == 2 : driven > 0;
}

/// Whether the border goes nearly straight on at a notch: a bend of the rim, where nothing is
/// missing.
bool is_bend(const Soup& soup, const CornerHole& hole) {
  constexpr double kStraightOn = -0.87;  // cosine of 150 degrees
  if (!hole.is_notch()) return false;
  const Eigen::Vector3d &middle = soup.vertices_m[hole.corners[1]],
                        before = soup.vertices_m[hole.corners[0]] - middle,
                        behind = soup.vertices_m[hole.corners[2]] - middle;
  return before.dot(behind) < kStraightOn * before.norm() * behind.norm();
}

/// The triangles that close a hole; none where they would not be flat.
std::vector<Closing> closing_of(const Soup& soup, const CornerHole& hole, double steepest_z) {
  const auto& c = hole.corners;
  if (c.size() == 3) {
    const Triangle t{c[0], c[1], c[2]};
    if (!is_flat(soup, t, steepest_z)) return {};
    return {{t, most_like(soup, hole.across)}};
  }
  // Of the two diagonals the one that parts the classes, else the shorter one.
  std::vector<Closing> best;
  double least = 0.0;
  for (const std::size_t first : {std::size_t{0}, std::size_t{1}}) {
    const auto at = [&](std::size_t k) { return (first + k) % 4; };
    const Triangle a{c[at(0)], c[at(1)], c[at(2)]}, b{c[at(0)], c[at(2)], c[at(3)]};
    if (!is_flat(soup, a, steepest_z) || !is_flat(soup, b, steepest_z)) continue;
    const std::vector<std::uint32_t> beside_a{hole.across[at(0)], hole.across[at(1)]},
        beside_b{hole.across[at(2)], hole.across[at(3)]};
    const auto differ = [&](const std::vector<std::uint32_t>& beside) {
      return soup.surface_class[beside[0]] != soup.surface_class[beside[1]];
    };
    const double cost = (soup.vertices_m[c[at(0)]] - soup.vertices_m[c[at(2)]]).norm() +
                        kLargestCornerHole_m * 4.0 *
                            ((differ(beside_a) ? 1.0 : 0.0) + (differ(beside_b) ? 1.0 : 0.0));
    if (!best.empty() && cost >= least) continue;
    // Where no diagonal parts them, what is road across the hole is road in it.
    const bool parts = !differ(beside_a) && !differ(beside_b);
    best = {{a, most_like(soup, parts ? beside_a : hole.across)},
            {b, most_like(soup, parts ? beside_b : hole.across)}};
    least = cost;
  }
  return best;
}

/// Other triangles of the mesh at the edges of a hole, a bit for each edge that has one.
struct Beside {
  std::uint32_t any = 0, flat = 0;
};

std::vector<Beside> beside_of(const Mesh& mesh, const std::vector<bool>& flat, const Soup& soup,
                              const std::vector<CornerHole>& holes, double near_m) {
  struct Corner {
    double x_m;
    std::uint32_t hole, number;
  };
  std::vector<Corner> corners;
  for (std::uint32_t h = 0; h < holes.size(); ++h)
    for (std::uint32_t k = 0; k < holes[h].corners.size(); ++k)
      corners.push_back({soup.vertices_m[holes[h].corners[k]].x(), h, k});
  std::sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) {
    return std::tuple(a.x_m, a.hole, a.number) < std::tuple(b.x_m, b.hole, b.number);
  });
  std::vector<char> in_soup(mesh.triangles.size(), 0);
  for (const std::uint32_t t : soup.source) in_soup[t] = 1;
  std::vector<Beside> found(holes.size());
  std::vector<std::pair<std::uint32_t, std::uint32_t>> touched;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (in_soup[t] != 0) continue;
    touched.clear();
    for (const std::uint32_t v : mesh.triangles[t]) {
      const Eigen::Vector3d& p = mesh.vertices_m[v];
      auto at = std::lower_bound(corners.begin(), corners.end(), p.x() - near_m,
                                 [](const Corner& a, double x_m) { return a.x_m < x_m; });
      for (; at != corners.end() && at->x_m <= p.x() + near_m; ++at)
        if ((soup.vertices_m[holes[at->hole].corners[at->number]] - p).norm() <= near_m)
          touched.emplace_back(at->hole, at->number);
    }
    for (const auto& [hole, a] : touched)
      for (const auto& [other, b] : touched)
        if (hole == other && b == (a + 1) % holes[hole].corners.size()) {
          found[hole].any |= 1U << a;
          if (flat[t]) found[hole].flat |= 1U << a;
        }
  }
  return found;
}

/// Whether something is missing there: nothing stands around a hole, and a notch is shown by what
/// goes on beyond it without lying in it.
bool is_missing(const CornerHole& hole, const Beside& beside) {
  if (hole.is_notch()) return (beside.any & 4U) != 0 && (beside.flat & 3U) == 0;
  return beside.any != (1U << hole.corners.size()) - 1U;
}

}  // namespace

void close_corner_holes(const Mesh& mesh, const std::vector<bool>& flat, Soup& soup,
                        const CleanOptions& options, CleanReport& facts) {
  const Borders borders(soup.triangles);
  std::vector<CornerHole> holes = borders.of(3);
  for (CornerHole& hole : borders.of(4)) holes.push_back(std::move(hole));
  for (CornerHole& notch : borders.notches()) holes.push_back(std::move(notch));
  const double steepest_z = std::cos(options.max_slope_deg * std::numbers::pi / 180.0);
  std::erase_if(holes, [&](const CornerHole& hole) {
    return longest_side_m(soup, hole) > kLargestCornerHole_m || !is_of_road(soup, hole) ||
           is_bend(soup, hole) || closing_of(soup, hole, steepest_z).empty();
  });
  if (holes.empty()) return;
  const std::vector<Beside> beside = beside_of(
      mesh, flat, soup, holes, std::max(options.weld_tolerance_m, options.snap_tolerance_m));
  double largest_m = 0.0;
  std::string where;
  std::size_t closed = 0;
  for (std::size_t h = 0; h < holes.size(); ++h) {
    if (!is_missing(holes[h], beside[h])) continue;
    for (const Closing& c : closing_of(soup, holes[h], steepest_z)) {
      soup.triangles.push_back(c.triangle);
      soup.source.push_back(soup.source[c.like]);
      soup.surface_class.push_back(soup.surface_class[c.like]);
      if (soup.surface_class.back() == SurfaceClass::road)
        facts.holes_closed_m2 += soup.area_vector_of(soup.triangles.size() - 1).norm();
    }
    if (++closed <= 3) {
      const Eigen::Vector3d p = mesh.origin_m + soup.vertices_m[holes[h].corners.front()];
      where += fmt::format("{}({:.1f}, {:.1f})", closed == 1 ? "" : ", ", p.x(), p.y());
    }
    largest_m = std::max(largest_m, longest_side_m(soup, holes[h]));
  }
  if (closed == 0) return;
  facts.holes_closed += closed;
  facts.remarks.push_back(fmt::format(
      "{} of the mesh, between three or four corners and up to {:.1f} m long, {} closed: at {}{}",
      closed == 1 ? "a hole" : fmt::format("{} holes", closed), largest_m,
      closed == 1 ? "was" : "were", where, closed > 3 ? ", ..." : ""));
}

}  // namespace road
