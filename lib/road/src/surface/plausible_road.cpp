// Roads that a surface may show, and the more plausible of those that names and shape tell.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/statistics.h"
#include "cleaning.h"
#include "fork.h"
#include "mesh/ray_surface.h"
#include "road/road_graph.h"
#include "strip_ends.h"

namespace road {
namespace {

// Shape is taken where it shows this much more road than the names do.
constexpr double kClearlyMore = 1.1;
/// The same where names find a closed road and little else: a verge round a circuit is closed and
/// longer than its road, by 1.31 on 400 m with its middle 20 m outside.
constexpr double kMuchMore = 1.5, kAllOfTheNamed = 0.8;
/// Names that show a closed road and no more than this beside it are sure where shape has none.
constexpr double kNearlyAll = 0.95;
/// An open road by names is as long as that by shape.
constexpr double kNoLonger = 0.95;
/// Names that call less than this share of the road by its shape a road do not tell which it is.
constexpr double kFewNamed = 0.3;
// Of flat ground beyond this multiple of the road only a part can be road.
constexpr double kMuchGround = 4.0;
// All of the ground is a road when its longest way covers this much of it, this slim or slimmer.
constexpr double kAllOfIt = 0.9;
constexpr double kRingSlimness = 0.1;
// Of a ring this wide a road by its shape may be a lane.
constexpr double kWideRing_m = 16.0;
// A strip of at least this share of the ring's length that ends where the ground does is open for
// want of ground.
constexpr double kMostOfRing = 0.5, kBeyondEnd_m = 1.0, kWidestOpen_m = 60.0, kWholeEnd = 0.8;

constexpr std::size_t kWaysLookedAt = 4;

double named_m2(const Mesh& mesh, const Triangles& triangles) {
  double sum_m2 = 0.0;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    if (triangles.flat[t] && triangles.by_names[t] == SurfaceClass::road)
      sum_m2 += area_vector(mesh.vertex(t, 0), mesh.vertex(t, 1), mesh.vertex(t, 2)).norm();
  return sum_m2;
}

double road_m2(const Soup& soup) {
  double sum_m2 = 0.0;
  for (std::size_t i = 0; i < soup.triangles.size(); ++i)
    if (soup.surface_class[i] == SurfaceClass::road) sum_m2 += soup.area_vector_of(i).norm();
  return sum_m2;
}

/// Whether a strip ends, over its width, only where the ground does.
bool ends_with_the_ground(const Soup& strip, double width_m, const Soup& ground) {
  const RaySurface rays(surface_of(ground));
  std::vector<End> ends = open_ends(road_triangles(strip), strip.vertices_m, kWidestOpen_m);
  std::erase_if(ends, [&](const End& end) { return end.width_m < kWholeEnd * width_m; });
  return !ends.empty() && std::all_of(ends.begin(), ends.end(), [&](const End& end) {
    const Eigen::Vector2d at = end.middle.head<2>() + kBeyondEnd_m * end.outward;
    return !rays.nearest_hit(at.x(), at.y(), end.middle.z(), kBeyondEnd_m).has_value();
  });
}

}  // namespace

double RoadShown::worth() const { return length_m * (closed ? 1.0 : 0.6) * std::sqrt(share); }

std::string text_of(const RoadShown& shown) {
  return shown.length_m == 0.0
             ? std::string("no road")
             : fmt::format("{} road of about {:.0f} m ({:.0f} % of what looks like road)",
                           shown.closed ? "a closed" : "an open", shown.length_m,
                           100.0 * shown.share);
}

RoadShown road_shown(const Soup& soup) {
  const RoadGraph graph = road_graph(surface_of(soup));
  const std::vector<RoadWay> ways = road_ways(graph, kRoadGap_m, kWaysLookedAt);
  if (ways.empty()) return {};
  double way_m2 = 0.0;
  const auto& points = ways[0].points_m;
  for (std::size_t i = 1; i < points.size(); ++i)
    way_m2 += 2.0 * ways[0].half_width_m[i] * (points[i] - points[i - 1]).head<2>().norm();
  return {ways[0].length_m, std::min(1.0, way_m2 / graph.area_m2),
          2.0 * base::median(ways[0].half_width_m), ways[0].closed, two_alike(ways)};
}

base::Answer<Cleaning> clean_by_shape(const Mesh& mesh, const Triangles& triangles,
                                      std::vector<SurfaceClass> by_shape,
                                      const CleanOptions& options, const CleanReport& facts) {
  double flat_m2 = 0.0, road_m2 = 0.0;
  std::vector<SurfaceClass> all_flat(mesh.triangles.size(), SurfaceClass::scenery);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!triangles.flat[t]) continue;
    const double area_m2 =
        0.5 * std::abs(area_vector(mesh.vertex(t, 0), mesh.vertex(t, 1), mesh.vertex(t, 2)).z());
    all_flat[t] = SurfaceClass::road;
    flat_m2 += area_m2;
    if (by_shape[t] == SurfaceClass::road) road_m2 += area_m2;
  }
  auto shaped = clean_classes(mesh, triangles, std::move(by_shape), options, facts, true);
  std::optional<Cleaning> whole;
  if (road_m2 == 0.0 || road_m2 > flat_m2 / kMuchGround ||
      (facts.by_place && options.guide_width_m))
    if (auto all = clean_classes(mesh, triangles, std::move(all_flat), options, facts, true))
      whole = *std::move(all);
  const RoadShown ground = whole ? road_shown(whole->soup) : RoadShown{};
  const bool is_ring =
      ground.closed && ground.share > kAllOfIt && ground.width_m < kRingSlimness * ground.length_m;
  const RoadShown strip = shaped ? road_shown(shaped->soup) : RoadShown{};
  const bool has_gaps = is_ring && strip.length_m > kMostOfRing * ground.length_m &&
                        ends_with_the_ground(shaped->soup, strip.width_m, whole->soup);
  if (is_ring && !strip.closed && !has_gaps) {
    whole->facts.remarks.push_back(fmt::format(
        "all of the flat ground is one closed road of about {:.0f} m, {:.1f} m wide; its shape "
        "alone tells no narrower road on it",
        ground.length_m, ground.width_m));
    return std::move(*whole);
  }
  if (!shaped) return shaped;
  if (facts.by_place) {
    const auto off_m = [&](const RoadShown& shown) {
      return std::abs(shown.width_m - *options.guide_width_m);
    };
    return is_ring && options.guide_width_m && off_m(ground) < off_m(strip) ? std::move(*whole)
                                                                            : std::move(shaped);
  }
  if (is_ring && strip.width_m < kLaneShare * ground.width_m && ground.width_m < kWideRing_m)
    shaped->facts.doubts.push_back(fmt::format(
        "by its shape the road is {:.1f} m wide, on flat ground that is itself a closed road, "
        "{:.1f} m wide: it may be one lane of it; take all of it by a rough line along its middle "
        "(--guide FILE), or, if the line is right all the same, say so with --line-is-right",
        strip.width_m, ground.width_m));
  return shaped;
}

base::Answer<Cleaning> more_plausible(const Mesh& mesh, const Triangles& triangles,
                                      std::vector<SurfaceClass> by_shape,
                                      const CleanOptions& options, const CleanReport& facts) {
  CleanReport shape_facts = facts;
  shape_facts.by_names = false;
  // Where shape finds nothing it is for the names to say what is wrong.
  auto shaped = clean_by_shape(mesh, triangles, std::move(by_shape), options, shape_facts);
  const RoadShown by_form = shaped ? road_shown(shaped->soup) : RoadShown{};
  auto named = clean_classes(mesh, triangles, triangles.by_names, options, facts, true);
  if (!named) {
    if (by_form.length_m == 0.0) return named;
    const std::string& refused = named.refusal().message;
    if (by_form.closed && by_form.share > kNearlyAll &&
        named_m2(mesh, triangles) < kFewNamed * road_m2(shaped->soup)) {
      shaped->facts.remarks.push_back(fmt::format(
          "names tell no road ({}); taken by shape, which finds {}", refused, text_of(by_form)));
      return shaped;
    }
    return base::Refusal(fmt::format("{}; shape alone finds {}", refused, text_of(by_form)));
  }
  const RoadShown by_name = road_shown(named->soup);
  if (by_name.alike) return base::Refusal(*by_name.alike);
  const bool whole = by_name.closed && by_name.share > kAllOfTheNamed;
  const bool take_shape = by_form.worth() > (whole ? kMuchMore : kClearlyMore) * by_name.worth();
  Cleaning& taken = take_shape ? *shaped : *named;
  taken.is_sure = !take_shape && by_name.closed && by_name.share > kNearlyAll && !by_form.closed;
  taken.facts.is_all_by_names = !take_shape && by_name.share > kNearlyAll && !by_form.closed &&
                                by_name.length_m > kNoLonger * by_form.length_m;
  taken.facts.remarks.push_back(fmt::format(
      "names and shape disagree about what is road: by names {}, by shape {}; taken by {} "
      "(--use-names {} takes the other)",
      text_of(by_name), text_of(by_form), take_shape ? "shape" : "names",
      take_shape ? "true" : "false"));
  return std::move(taken);
}

}  // namespace road
