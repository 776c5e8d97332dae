#include "classify_by_shape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <tuple>
#include <unordered_set>
#include <utility>

#include "band_strips.h"
#include "bands.h"
#include "base/statistics.h"
#include "chains.h"
#include "fans.h"
#include "shape_runoff.h"
#include "strip_ends.h"

namespace road {
namespace {

// A steady strip counts as the road unless a merely smooth one joins many more cross sections.
constexpr double kAsManyRings = 0.7;

// Up to this width all columns in one plane are the likelier road, beyond it one of them.
constexpr double kWideRoad_m = 16.0;

// Less between two strips is a line on one road.
constexpr double kMedian_m = 1.0;

// A strip that continues the road across a gap has its width.
constexpr double kSameWidth = 0.1;

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

double most_rings(const std::vector<Strip>& of) {
  std::size_t most = 0;
  for (const Strip& strip : of) most = std::max(most, strip.rings);
  return static_cast<double>(most);
}

struct Strips {
  std::vector<Strip> steady, smooth, joined;  // joined: with all columns in one plane
};

Strips strips_of(const FlatSurface& flat, const Fans& fans, const std::vector<Chain>& chains) {
  std::vector<Band> bands;  // two for every chain: left, right
  for (std::size_t i = 0; i < chains.size(); ++i) {
    bands.push_back(band_beside(flat, fans, chains, i, true));
    bands.push_back(band_beside(flat, fans, chains, i, false));
  }
  const auto long_enough = [&](std::size_t b) {
    return bands[b].length_m >= kShortestChain_m && bands[b].width_m <= kWidestRoad_m;
  };
  const auto steady = [&](std::size_t b) {
    return long_enough(b) && bands[b].steady >= kSteadyShare;
  };
  const auto smooth = [&](std::size_t b) {
    return long_enough(b) && bands[b].smooth >= kSteadyShare;
  };
  return {strips_of_bands(flat, fans, chains, bands, steady, Columns::as_wide),
          strips_of_bands(flat, fans, chains, bands, smooth, Columns::as_wide),
          strips_of_bands(flat, fans, chains, bands, smooth, Columns::any)};
}

/// All that may be road: the steady strips, unless the merely smooth ones join many more cross
/// sections.
std::vector<Strip> likely_strips(Strips strips) {
  return most_rings(strips.steady) < kAsManyRings * most_rings(strips.smooth)
             ? std::move(strips.smooth)
         : strips.steady.empty() ? std::move(strips.joined)  // columns narrower than any road
                                 : std::move(strips.steady);
}

/// All, of those that are alike the first one.
std::vector<Strip> all_strips(Strips strips) {
  std::vector<Strip> all = std::move(strips.steady);
  std::vector<Strip> others = std::move(strips.smooth);
  others.insert(others.end(), strips.joined.begin(), strips.joined.end());
  for (Strip& strip : others) {
    const bool known = std::any_of(all.begin(), all.end(), [&](const Strip& other) {
      std::vector<std::uint32_t> common;
      std::set_intersection(strip.triangles.begin(), strip.triangles.end(), other.triangles.begin(),
                            other.triangles.end(), std::back_inserter(common));
      return 2 * common.size() > strip.triangles.size();
    });
    if (!known) all.push_back(std::move(strip));
  }
  return all;
}

/// The road has the most cross sections, or nearly; of these strips the long ones.
std::vector<const Strip*> long_strips(const std::vector<Strip>& strips) {
  const double fewest_rings = kAsManyRings * most_rings(strips);
  double longest_m = 0.0;
  for (const Strip& strip : strips) {
    if (static_cast<double>(strip.rings) >= fewest_rings)
      longest_m = std::max(longest_m, strip.length_m());
  }
  std::vector<const Strip*> found;
  for (const Strip& strip : strips)
    if (static_cast<double>(strip.rings) >= fewest_rings && strip.length_m() >= kAsLong * longest_m)
      found.push_back(&strip);
  return found;
}

/// Of the long strips the widest.
const Strip& main_strip(const std::vector<Strip>& strips) {
  const std::vector<const Strip*> from = long_strips(strips);
  return **std::max_element(from.begin(), from.end(), [](const Strip* a, const Strip* b) {
    return a->width_m() < b->width_m();
  });
}

/// Another strip as long and wide that is neither the road nor beside it, but for a line between.
const Strip* twin_of(const FlatSurface& flat, const Fans& fans, const std::vector<Strip>& strips,
                     const Strip& chosen, const std::vector<char>& road) {
  for (const Strip* strip : long_strips(strips)) {
    const auto of_road = std::count_if(strip->triangles.begin(), strip->triangles.end(),
                                       [&](std::uint32_t t) { return road[t] != 0; });
    if (strip != &chosen && 2 * static_cast<std::size_t>(of_road) < strip->triangles.size() &&
        std::abs(strip->width_m() - chosen.width_m()) < kSameWidth * chosen.width_m() &&
        beside_road(flat, fans, road, *strip) < 0.5 &&
        close_to_road(flat, road, *strip, kMedian_m) < 0.5)
      return strip;
  }
  return nullptr;
}

bool lies_on(const Eigen::Vector2d& p, const FlatSurface& flat, const Triangle& t) {
  const auto side = [&](std::size_t c) {
    const Eigen::Vector2d a = flat.vertices_m[t[c]].head<2>(),
                          b = flat.vertices_m[t[(c + 1) % 3]].head<2>();
    return (b - a).x() * (p - a).y() - (b - a).y() * (p - a).x();
  };
  return side(0) >= 0.0 && side(1) >= 0.0 && side(2) >= 0.0;
}

bool lies_on(const Eigen::Vector2d& p, const FlatSurface& flat, const Strip& strip) {
  return std::any_of(strip.triangles.begin(), strip.triangles.end(),
                     [&](std::uint32_t t) { return lies_on(p, flat, flat.triangles[t]); });
}

/// Of the strips on which the place lies the one about as wide as told, else the first.
const Strip* strip_at(const FlatSurface& flat, const std::vector<Strip>& strips,
                      const StripPlace& place) {
  const Strip* found = nullptr;
  const auto off_m = [&](const Strip& strip) { return std::abs(strip.width_m() - *place.width_m); };
  for (const Strip& strip : strips)
    if (lies_on(place.at_m, flat, strip) &&
        (found == nullptr || (place.width_m && off_m(strip) < off_m(*found))))
      found = &strip;
  return found;
}

/// In the middle of the largest triangle.
Eigen::Vector2d place_on(const FlatSurface& flat, const Strip& strip) {
  double largest_m2 = 0.0;
  Eigen::Vector2d place_m = Eigen::Vector2d::Zero();
  for (const std::uint32_t t : strip.triangles) {
    const Triangle& v = flat.triangles[t];
    const Eigen::Vector3d &a = flat.vertices_m[v[0]], &b = flat.vertices_m[v[1]],
                          &c = flat.vertices_m[v[2]];
    const double area_m2 = (b - a).cross(c - a).norm();
    if (area_m2 <= largest_m2) continue;
    largest_m2 = area_m2;
    place_m = ((a + b + c) / 3.0).head<2>();
  }
  return place_m;
}

/// The road grown so far, and what else there is to go on with.
class GrowingRoad {
 public:
  GrowingRoad(const FlatSurface& flat, const Fans& fans, const std::vector<Chain>& chains,
              const std::vector<Strip>& strips, const Strip& chosen)
      : flat_(flat),
        fans_(fans),
        chains_(chains),
        strips_(strips),
        width_m_(chosen.width_m()),
        road_(flat.triangles.size(), 0),
        ends_of_strip_(strips.size()),
        joined_(strips.size(), 0) {
    add(chosen);
    for (std::size_t k = 0; k < strips.size(); ++k) {
      if (&strips[k] == &chosen || std::abs(strips[k].width_m() - width_m_) > kSameWidth * width_m_)
        continue;
      ends_of_strip_[k] =
          open_ends(triangles_of(flat, strips[k].triangles), flat.vertices_m, 1.3 * width_m_);
    }
  }

  /// Goes on where the chains broke: along the open columns, then over to other strips of this
  /// width whose end faces one of the road's. Gives back a mark for every triangle.
  std::vector<char> grow() {
    for (bool changed = true; changed;) {
      for (const End& end : road_ends(flat_, road_, width_m_, sides_)) {
        for (std::size_t i = 0; i + 1 < end.vertices.size(); ++i)
          march(flat_, fans_, end.vertices[i], end.vertices[i + 1], road_);
      }
      const std::vector<End> ends = road_ends(flat_, road_, width_m_, sides_);
      changed = false;
      for (std::size_t k = 0; k < strips_.size(); ++k) {
        if (joined_[k] || ends_of_strip_[k].empty() || !faces(k, ends)) continue;
        add(strips_[k]);
        joined_[k] = 1;
        changed = true;
      }
    }
    return std::move(road_);
  }

 private:
  void add(const Strip& strip) {
    for (const std::size_t c : strip.chains) {
      for (std::size_t i = 0; i < chains_[c].edges(); ++i)
        sides_.insert(undirected(chains_[c].at(i), chains_[c].at(i + 1)));
    }
    for (const std::uint32_t t : strip.triangles) road_[t] = 1;
  }

  /// Whether an end of strip k faces one of the road's ends, across a gap and not beside the road.
  bool faces(std::size_t k, const std::vector<End>& ends) const {
    std::vector<End> both = ends;
    both.insert(both.end(), ends_of_strip_[k].begin(), ends_of_strip_[k].end());
    const auto of_road = [&](const End& end) {
      return std::any_of(ends.begin(), ends.end(),
                         [&](const End& other) { return other.vertices == end.vertices; });
    };
    const std::vector<Gap> gaps = facing_ends(both, kLongestGap_m);
    // One end of each; a strip that already is road faces itself.
    return std::any_of(gaps.begin(), gaps.end(), [&](const Gap& gap) {
      return of_road(gap.a) != of_road(gap.b) &&
             !(beside_road(flat_, fans_, road_, strips_[k]) > 0.3);
    });
  }

  const FlatSurface& flat_;
  const Fans& fans_;
  const std::vector<Chain>& chains_;
  const std::vector<Strip>& strips_;
  double width_m_;
  std::vector<char> road_;
  std::unordered_set<std::uint64_t> sides_;
  std::vector<std::vector<End>> ends_of_strip_;
  std::vector<char> joined_;
};

}  // namespace

ShapeClasses classify_by_shape(const FlatSurface& flat, const std::optional<StripPlace>& place) {
  ShapeClasses out;
  out.class_of_triangle.assign(flat.triangles.size(), SurfaceClass::scenery);
  const Fans fans(flat);
  const std::vector<Chain> chains = long_chains(flat, fans);
  Strips found = strips_of(flat, fans, chains);
  const std::vector<Strip> joined = found.joined;
  std::vector<Strip> strips;
  const Strip* chosen = nullptr;
  if (place) {
    strips = all_strips(std::move(found));
    if (place->width_m) strips.insert(strips.end(), joined.begin(), joined.end());
    chosen = strip_at(flat, strips, *place);
    out.is_told = chosen != nullptr;
  } else if (strips = likely_strips(std::move(found)); !strips.empty()) {
    chosen = &main_strip(strips);
    out.rival_width_m = rival_width_m(flat, fans, chains, strips, *chosen);
    if (const Strip* wider = wider_strip(flat, chains, joined, *chosen);
        wider != nullptr && wider->width_m() < kWideRoad_m && !is_whole_road(*chosen))
      out.in_one_plane_m = wider->width_m();
  }
  if (chosen == nullptr) return out;
  out.road_length_m = chosen->length_m();
  out.road_width_m = chosen->width_m();
  std::vector<char> road = GrowingRoad(flat, fans, chains, strips, *chosen).grow();
  if (!out.is_told)
    if (const Strip* twin = twin_of(flat, fans, strips, *chosen, road))
      out.twin_m = place_on(flat, *twin);
  grow_runoff(flat, fans, road);
  for (std::uint32_t t = 0; t < flat.triangles.size(); ++t) {
    if (road[t] == 1) out.class_of_triangle[t] = SurfaceClass::road;
    if (road[t] == 2) out.class_of_triangle[t] = SurfaceClass::runoff;
  }
  return out;
}

std::vector<StripPlace> places_by_shape(const FlatSurface& flat) {
  const Fans fans(flat);
  const std::vector<Chain> chains = long_chains(flat, fans);
  Strips all = strips_of(flat, fans, chains);
  const std::vector<Strip> joined = all.joined;
  const std::vector<Strip> strips = all_strips(std::move(all));
  struct Ranked {
    double uneven_m;
    bool at_rim;
    const Strip* strip;
  };
  std::vector<Ranked> ranked;
  double even_m = std::numeric_limits<double>::infinity();
  for (const Strip* strip : long_strips(strips)) {
    ranked.push_back(
        {unevenness_m(flat, chains, *strip), !has_ground_beside(flat, fans, *strip), strip});
    even_m = std::min(even_m, ranked.back().uneven_m);
  }
  std::stable_sort(ranked.begin(), ranked.end(), [&](const Ranked& a, const Ranked& b) {
    return std::tuple(is_uneven(a.uneven_m, even_m), a.at_rim, -a.strip->width_m()) <
           std::tuple(is_uneven(b.uneven_m, even_m), b.at_rim, -b.strip->width_m());
  });
  std::vector<StripPlace> found;
  for (const Ranked& r : ranked) {
    StripPlace place{place_on(flat, *r.strip), {}};
    // Where a narrower one has this place, its width tells that this one is meant.
    if (strip_at(flat, strips, place) != r.strip) place.width_m = r.strip->width_m();
    if (place.width_m && *place.width_m >= kWideRoad_m) continue;
    const Strip* wider =
        is_whole_road(*r.strip) ? nullptr : wider_strip(flat, chains, joined, *r.strip);
    const bool is_road = wider != nullptr && wider->width_m() < kWideRoad_m;
    if (is_road) found.push_back({place.at_m, wider->width_m()});
    found.push_back(place);
    if (wider != nullptr && !is_road) found.push_back({place.at_m, wider->width_m()});
  }
  return found;
}

}  // namespace road
