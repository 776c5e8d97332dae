#include "grow_road.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <unordered_set>

#include "chains.h"
#include "fans.h"
#include "strip_ends.h"

namespace road {
namespace {

// What continues the road across a gap has its width, a short piece at its end, too. Its sides are
// this many widths long and have this many edges, at least.
constexpr double kAsWide = 0.1, kShortestPiece = 1.5, kHardlyOn = 0.1;
constexpr std::size_t kFewestEdges = 3;

/// Follows a column of quads across `front` (surface behind it on its left) as long as it keeps its
/// width.
void march(const FlatSurface& flat, const Fans& fans, std::uint32_t p, std::uint32_t q,
           std::vector<char>& road) {
  const auto at = [&](std::uint32_t v) { return Eigen::Vector2d(flat.vertices_m[v].head<2>()); };
  const double width = (at(q) - at(p)).norm();
  Eigen::Vector2d ahead((at(q) - at(p)).y(), -(at(q) - at(p)).x());
  ahead.normalize();
  std::vector<std::uint32_t> passed;
  std::uint32_t behind = fans.left(p, q);
  if (behind == kNoIndex) return;
  while (true) {
    const std::uint32_t t = fans.left(q, p);
    if (t == kNoIndex || road[t]) return;
    const std::uint32_t x = fans.apex(t, q, p);
    // The new front is (p, x) or (x, q): the one along which the side left behind goes straight
    // ahead.
    const Eigen::Vector2d from_q = (at(x) - at(q)).normalized();
    const Eigen::Vector2d from_p = (at(x) - at(p)).normalized();
    const bool moves_q = from_q.dot(ahead) > from_p.dot(ahead);
    const Eigen::Vector2d along = moves_q ? from_q : from_p;
    const std::uint32_t next_p = moves_q ? p : x;
    const std::uint32_t next_q = moves_q ? x : q;
    // Width across the direction of travel: a diagonal front is longer than the road is wide.
    const Eigen::Vector2d chord = at(next_q) - at(next_p);
    const double across = std::abs(chord.x() * along.y() - chord.y() * along.x());
    const bool folded = normal_of(flat, t).dot(normal_of(flat, behind)) < kHill;
    behind = t;
    if (folded || along.dot(ahead) < 0.5 || std::abs(across - width) > 0.1 * width) {
      for (const std::uint32_t s : passed) road[s] = 0;
      return;
    }
    passed.push_back(t);
    road[t] = 1;
    ahead = (0.5 * ahead + 0.5 * along).normalized();
    p = next_p;
    q = next_q;
  }
}

std::vector<Triangle> triangles_of(const FlatSurface& flat,
                                   const std::vector<std::uint32_t>& indices) {
  std::vector<Triangle> out;
  out.reserve(indices.size());
  for (const std::uint32_t t : indices) out.push_back(flat.triangles[t]);
  return out;
}

/// The open ends of the road that span its whole width.
std::vector<End> road_ends(const FlatSurface& flat, const std::vector<char>& road, double width_m,
                           const std::unordered_set<std::uint64_t>& sides) {
  std::vector<Triangle> triangles;
  for (std::uint32_t t = 0; t < flat.triangles.size(); ++t) {
    if (road[t]) triangles.push_back(flat.triangles[t]);
  }
  std::vector<End> ends = open_ends(triangles, flat.vertices_m, 1.3 * width_m);
  std::erase_if(ends, [&](const End& end) {
    // Two kinks of one side of the road look like an end, too.
    bool on_side = false;
    for (std::size_t i = 0; i + 1 < end.vertices.size(); ++i) {
      on_side = on_side || sides.contains(undirected(end.vertices[i], end.vertices[i + 1]));
    }
    return on_side || end.width_m < 0.9 * width_m;
  });
  return ends;
}

/// The road grown so far.
class GrowingRoad {
 public:
  GrowingRoad(const FlatSurface& flat, const Fans& fans, double width_m)
      : flat_(flat), fans_(fans), width_m_(width_m), road_(flat.triangles.size(), 0) {}

  void add(const std::vector<Chain>& chains, const Strip& strip) {
    for (const std::size_t c : strip.chains) {
      for (std::size_t i = 0; i < chains[c].edges(); ++i)
        sides_.insert(undirected(chains[c].at(i), chains[c].at(i + 1)));
    }
    for (const std::uint32_t t : strip.triangles) road_[t] = 1;
  }

  /// Goes on along the open columns, then over to strips of this width whose end faces one of the
  /// road's; short ones must lie off the road and end as wide as it. Whether any does.
  bool join(const std::vector<Chain>& chains, const std::vector<Strip>& strips, bool are_short) {
    std::vector<std::vector<End>> ends_of_strip;
    bool any = false;
    for (bool changed = true; changed;) {
      const std::vector<End> ends = ends_after_march();
      if (ends.empty()) break;
      for (std::size_t k = ends_of_strip.size(); k < strips.size(); ++k) {
        ends_of_strip.emplace_back();
        if (!is_piece(strips[k], are_short ? kHardlyOn : 1.0)) continue;
        ends_of_strip[k] =
            open_ends(triangles_of(flat_, strips[k].triangles), flat_.vertices_m, 1.3 * width_m_);
        std::erase_if(ends_of_strip[k], [&](const End& end) {
          return are_short && std::abs(end.width_m - width_m_) > kAsWide * width_m_;
        });
      }
      changed = false;
      for (std::size_t k = 0; k < strips.size(); ++k) {
        if (ends_of_strip[k].empty() || !faces(strips[k], ends_of_strip[k], ends)) continue;
        add(chains, strips[k]);
        ends_of_strip[k].clear();
        any = changed = true;
      }
    }
    return any;
  }

  /// Over to pieces that are too short to be a road by themselves. Whether there is one.
  bool join_short_ones() {
    const std::vector<End> ends = ends_after_march();
    if (ends.empty()) return false;
    const double shortest_m = kShortestPiece * width_m_;
    std::vector<Chain> chains = long_chains(flat_, fans_, shortest_m, kFewestEdges);
    std::erase_if(chains, [&](const Chain& chain) {
      return std::none_of(chain.vertices.begin(), chain.vertices.end(), [&](std::uint32_t v) {
        return std::any_of(ends.begin(), ends.end(), [&](const End& end) {
          return (flat_.vertices_m[v] - end.middle).head<2>().norm() < kLongestGap_m + width_m_;
        });
      });
    });
    return join(chains, all_strips(strips_of(flat_, fans_, chains, shortest_m)), true);
  }

  std::vector<char> marks() && { return std::move(road_); }

 private:
  std::vector<End> ends_after_march() {
    const std::vector<End> ends = road_ends(flat_, road_, width_m_, sides_);
    if (ends.empty()) return ends;
    for (const End& end : ends)
      for (std::size_t i = 0; i + 1 < end.vertices.size(); ++i)
        march(flat_, fans_, end.vertices[i], end.vertices[i + 1], road_);
    return road_ends(flat_, road_, width_m_, sides_);
  }

  /// As wide as the road, and less than a share of it on the road already.
  bool is_piece(const Strip& strip, double share) const {
    const auto on_road = std::count_if(strip.triangles.begin(), strip.triangles.end(),
                                       [&](std::uint32_t t) { return road_[t] != 0; });
    const double area_m2 = width_m_ * (strip.length_m() - width_m_);  // its border has two ends
    return static_cast<double>(on_road) < share * static_cast<double>(strip.triangles.size()) &&
           std::abs(strip.area_m2 - area_m2) <= kAsWide * area_m2;
  }

  /// Whether one of a strip's ends faces one of the road's, across a gap and not beside the road.
  bool faces(const Strip& strip, const std::vector<End>& ends_of_strip,
             const std::vector<End>& ends) const {
    std::vector<End> both = ends;
    both.insert(both.end(), ends_of_strip.begin(), ends_of_strip.end());
    const auto of_road = [&](const End& end) {
      return std::any_of(ends.begin(), ends.end(),
                         [&](const End& other) { return other.vertices == end.vertices; });
    };
    const std::vector<Gap> gaps = facing_ends(both, kLongestGap_m);
    // One end of each; a strip that already is road faces itself.
    return std::any_of(gaps.begin(), gaps.end(), [&](const Gap& gap) {
      return of_road(gap.a) != of_road(gap.b) && !(beside_road(flat_, fans_, road_, strip) > 0.3);
    });
  }

  const FlatSurface& flat_;
  const Fans& fans_;
  double width_m_;
  std::vector<char> road_;
  std::unordered_set<std::uint64_t> sides_;
};

}  // namespace

std::vector<char> grow_road(const FlatSurface& flat, const Fans& fans,
                            const std::vector<Chain>& chains, const std::vector<Strip>& strips,
                            const Strip& chosen) {
  GrowingRoad road(flat, fans, chosen.width_m());
  road.add(chains, chosen);
  road.join(chains, strips, false);
  while (road.join_short_ones()) {
  }
  return std::move(road).marks();
}

}  // namespace road
