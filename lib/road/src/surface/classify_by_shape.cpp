#include "classify_by_shape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "band_strips.h"
#include "bands.h"
#include "base/statistics.h"
#include "chains.h"
#include "fans.h"
#include "grow_road.h"
#include "shape_runoff.h"

namespace road {
namespace {

// A steady strip counts as the road unless a merely smooth one joins many more cross sections.
constexpr double kAsManyRings = 0.7;

// Up to this width all columns in one plane are the likelier road, beyond it one of them.
constexpr double kWideRoad_m = 16.0;

// Less between two strips is a line on one road.
constexpr double kMedian_m = 1.0;

// Twins are as wide as each other.
constexpr double kSameWidth = 0.1;

double most_rings(const std::vector<Strip>& of) {
  std::size_t most = 0;
  for (const Strip& strip : of) most = std::max(most, strip.rings);
  return static_cast<double>(most);
}

/// All that may be road: the steady strips, unless the merely smooth ones join many more cross
/// sections.
std::vector<Strip> likely_strips(Strips strips) {
  return most_rings(strips.steady) < kAsManyRings * most_rings(strips.smooth)
             ? std::move(strips.smooth)
         : strips.steady.empty() ? std::move(strips.joined)  // columns narrower than any road
                                 : std::move(strips.steady);
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
    if (place->width_m) {
      const std::vector<Strip> roads = roads_of_halves(flat, fans, chains, strips);
      strips.insert(strips.end(), joined.begin(), joined.end());
      strips.insert(strips.end(), roads.begin(), roads.end());
    }
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
  std::vector<char> road = grow_road(flat, fans, chains, strips, *chosen);
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
  const std::vector<Strip> of_halves = roads_of_halves(flat, fans, chains, strips);
  const auto add_of_halves = [&](bool wide) {
    for (const Strip& road : of_halves)
      if ((road.width_m() >= kWideRoad_m) == wide)
        found.push_back({place_on(flat, road), road.width_m()});
  };
  add_of_halves(false);
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
  add_of_halves(true);
  return found;
}

}  // namespace road
