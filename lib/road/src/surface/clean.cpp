#include "road/clean.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "base/statistics.h"
#include "classify_by_guide.h"
#include "clean_classes.h"
#include "clean_gaps.h"
#include "clean_parts.h"
#include "clean_soup.h"
#include "fork.h"
#include "mesh_topology.h"
#include "road/centreline.h"
#include "road/error.h"
#include "road_graph.h"
#include "roads_of.h"
#include "route.h"

namespace road {
namespace {

// Vertices snapped at a border must agree in height, or the lip of a kerb would be flattened.
constexpr double kSnapHeight_m = 0.001;
constexpr double kTornHeight_m = 0.005;
// Names that geometry confirms to this degree are believed without a second look.
constexpr double kNamesAreRight = 0.9;
// Shape is taken where it shows this much more road than the names do.
constexpr double kClearlyMore = 1.1;
/// The same where names find a closed road and little else: a verge round a circuit is closed and
/// longer than its road, by 1.31 on 400 m with its middle 20 m outside.
constexpr double kMuchMore = 1.5, kAllOfTheNamed = 0.8;
// The longest piece of missing road that a look at the whole takes for a gap.
constexpr double kRoadGap_m = 12.0;
// A second look that makes the road longer than this has gone astray at a wide place.
constexpr double kDetour = 1.01;
// Of flat ground beyond this multiple of the road only a part can be road.
constexpr double kMuchGround = 4.0;
// All of the ground is a road when its longest way covers this much of it, this slim or slimmer.
constexpr double kAllOfIt = 0.9;
constexpr double kRingSlimness = 0.1;
// A road by its shape that is narrower than this share of a ring this wide may be a lane of it.
constexpr double kLaneShare = 0.6;
constexpr double kWideRing_m = 16.0;

/// What is left of several roads.
enum class Keep : std::uint8_t { one, touching_road, all };

/// A cleaned surface, and the road that its graph shows.
struct Cleaning {
  Soup soup;
  CleanReport facts;
  std::vector<SurfaceClass> class_of_triangle;
};

/// Everything from classes to a welded surface. With `doubtful` classes (nobody confirms them) also
/// gaps that are longer than a crack are looked at.
Cleaning clean_classes(const Mesh& mesh, const Triangles& triangles,
                       std::vector<SurfaceClass> class_of_triangle, const CleanOptions& options,
                       CleanReport facts, bool doubtful, Keep keep = Keep::one) {
  const auto build_soup = [&](CleanReport& counted) {
    std::vector<std::uint32_t> kept;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      const SurfaceClass surface_class = class_of_triangle[i];
      if (surface_class == SurfaceClass::barrier || surface_class == SurfaceClass::scenery) {
        ++counted.dropped[to_string(surface_class)];
      } else if (triangles.empty[i]) {
        ++counted.dropped["zero area"];
      } else if (!triangles.flat[i] && surface_class != SurfaceClass::kerb) {
        ++counted.dropped["too steep"];
      } else {
        kept.push_back(i);
      }
    }
    return make_soup(mesh, kept, class_of_triangle, options, counted);
  };
  CleanReport first = facts;
  Soup soup = build_soup(first);
  if (keep == Keep::one &&
      fill_gaps_from_other_names(mesh, soup, triangles.flat, class_of_triangle, facts)) {
    first = facts;
    soup = build_soup(first);
  }
  facts = std::move(first);
  std::vector<Bridge> bridges;
  if (doubtful)
    bridges = fill_gaps_between_ends(mesh, road_graph(surface_of(soup)), triangles.flat,
                                     class_of_triangle, facts);
  if (!bridges.empty()) {
    facts.dropped.clear();
    facts.vertices_welded = facts.faces_turned = 0;
    soup = build_soup(facts);
  }
  double snap_height_m = kSnapHeight_m;
  if (options.snap_tolerance_m > 0.0 && is_torn(soup.triangles)) {
    snap_height_m = kTornHeight_m;
    facts.remarks.push_back(
        fmt::format("the triangles hardly share corners at {} mm: border vertices up to {} mm "
                    "apart in height were "
                    "joined; heights are no better than that",
                    1000.0 * options.weld_tolerance_m, 1000.0 * kTornHeight_m));
  }
  snap_borders(soup, options.snap_tolerance_m, snap_height_m, facts);
  bridge_gaps(
      soup, [](std::size_t) { return true; }, mesh.origin_m, options, facts);
  bridge_gaps(
      soup, [&](std::size_t i) { return soup.surface_class[i] == SurfaceClass::road; },
      mesh.origin_m, options, facts);
  if (keep == Keep::touching_road) keep_what_touches_road(soup, facts);
  if (keep == Keep::one) keep_one_circuit(soup, bridges, mesh.origin_m, options, facts);
  if (soup.triangles.empty()) {
    throw Error(
        fmt::format("nothing to drive on: {} triangles in {} objects, none of them road; give a "
                    "mesh with a road, "
                    "or name rules that find it",
                    mesh.triangles.size(), mesh.objects.size()));
  }
  return {std::move(soup), std::move(facts), std::move(class_of_triangle)};
}

/// How much road a surface shows: the longest way through it, less what is not closed, and less
/// what lies beside it.
struct RoadShown {
  double length_m = 0.0, share = 0.0, width_m = 0.0;
  bool closed = false;
  double worth() const { return length_m * (closed ? 1.0 : 0.6) * std::sqrt(share); }
};

RoadShown road_shown(const Soup& soup) {
  const RoadGraph graph = road_graph(surface_of(soup));
  const std::vector<RoadWay> ways = road_ways(graph, kRoadGap_m, 1);
  if (ways.empty()) return {};
  double way_m2 = 0.0;
  const auto& points = ways[0].points_m;
  for (std::size_t i = 1; i < points.size(); ++i)
    way_m2 += 2.0 * ways[0].half_width_m[i] * (points[i] - points[i - 1]).head<2>().norm();
  return {ways[0].length_m, std::min(1.0, way_m2 / graph.area_m2),
          2.0 * base::median(ways[0].half_width_m), ways[0].closed};
}

/// The road by its shape. Where the flat ground as a whole is a closed road, shape must not find
/// only a part of it: the whole is taken in place of an open strip, and a closed lane that is much
/// narrower is doubted.
Cleaning clean_by_shape(const Mesh& mesh, const Triangles& triangles,
                        std::vector<SurfaceClass> by_shape, const CleanOptions& options,
                        const CleanReport& facts) {
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
  std::optional<Cleaning> shaped;
  std::optional<Error> refused;
  try {
    shaped = clean_classes(mesh, triangles, std::move(by_shape), options, facts, true);
  } catch (const Error& error) {
    refused = error;
  }
  std::optional<Cleaning> whole;
  if (road_m2 == 0.0 || road_m2 > flat_m2 / kMuchGround) {
    try {
      whole = clean_classes(mesh, triangles, std::move(all_flat), options, facts, true);
    } catch (const Error&) {  // no road then
    }
  }
  const RoadShown ground = whole ? road_shown(whole->soup) : RoadShown{};
  const bool is_ring =
      ground.closed && ground.share > kAllOfIt && ground.width_m < kRingSlimness * ground.length_m;
  const RoadShown strip = shaped ? road_shown(shaped->soup) : RoadShown{};
  if (is_ring && !strip.closed) {
    whole->facts.remarks.push_back(fmt::format(
        "all of the flat ground is one closed road of about {:.0f} m, {:.1f} m wide; its shape "
        "alone tells no narrower road on it",
        ground.length_m, ground.width_m));
    return std::move(*whole);
  }
  if (!shaped) throw *refused;
  if (is_ring && strip.width_m < kLaneShare * ground.width_m && ground.width_m < kWideRing_m)
    shaped->facts.doubts.push_back(fmt::format(
        "by its shape the road is {:.1f} m wide, on flat ground that is itself a closed road, "
        "{:.1f} m wide: it may be one lane of it; take all of it by a rough line along its middle "
        "(--guide FILE), or, if the line is right all the same, say so with --line-is-right",
        strip.width_m, ground.width_m));
  return std::move(*shaped);
}

/// Both ways of telling road from scenery, and of these the one that shows more of a road; says
/// which and why. Throws what the names' way throws, with what shape finds as a way out.
Cleaning more_plausible(const Mesh& mesh, const Triangles& triangles,
                        std::vector<SurfaceClass> by_shape, const CleanOptions& options,
                        const CleanReport& facts) {
  CleanReport shape_facts = facts;
  shape_facts.by_names = false;
  const auto text = [](const RoadShown& shown) {
    return shown.length_m == 0.0
               ? std::string("no road")
               : fmt::format("{} road of about {:.0f} m ({:.0f} % of what looks like road)",
                             shown.closed ? "a closed" : "an open", shown.length_m,
                             100.0 * shown.share);
  };
  std::optional<Cleaning> shaped;
  try {
    shaped = clean_by_shape(mesh, triangles, std::move(by_shape), options, shape_facts);
  } catch (const Error&) {  // shape finds nothing: then it is for the names to say what is wrong
  }
  const RoadShown by_form = shaped ? road_shown(shaped->soup) : RoadShown{};
  std::optional<Cleaning> named;
  try {
    named = clean_classes(mesh, triangles, triangles.by_names, options, facts, true);
  } catch (const Error& refused) {
    if (by_form.length_m == 0.0) throw;
    throw Error(fmt::format("{}; shape alone finds {}", refused.what(), text(by_form)));
  }
  const RoadShown by_name = road_shown(named->soup);
  const bool whole = by_name.closed && by_name.share > kAllOfTheNamed;
  const bool take_shape = by_form.worth() > (whole ? kMuchMore : kClearlyMore) * by_name.worth();
  Cleaning& taken = take_shape ? *shaped : *named;
  taken.facts.remarks.push_back(fmt::format(
      "names and shape disagree about what is road: by names {}, by shape {}; taken by {} "
      "(--use-names {} takes the other)",
      text(by_name), text(by_form), take_shape ? "shape" : "names", take_shape ? "true" : "false"));
  return std::move(taken);
}

/// The surface as others see it.
RoadMesh road_mesh_of(const Mesh& mesh, const Cleaning& cleaning) {
  const Soup& soup = cleaning.soup;
  RoadMesh road;
  road.mesh.origin_m = mesh.origin_m;
  road.mesh.vertices_m = soup.vertices_m;
  road.mesh.triangles = soup.triangles;
  road.mesh.object_of_triangle.reserve(soup.source.size());
  for (const std::uint32_t i : soup.source)
    road.mesh.object_of_triangle.push_back(mesh.object_of_triangle[i]);
  road.mesh.objects = mesh.objects;
  road.class_of_triangle = soup.surface_class;
  return road;
}

/// Classes from what lies along a guide.
Cleaning clean_along(const Mesh& mesh, const Guide& guide, const Triangles& triangles,
                     const CleanOptions& options, CleanReport facts) {
  facts.by_guide = true;
  GuidedClasses guided =
      classes_along(mesh, guide, options.guide_width_m, triangles.flat, triangles.by_names);
  facts.remarks.insert(facts.remarks.end(), guided.remarks.begin(), guided.remarks.end());
  facts.doubts = std::move(guided.doubts);
  return clean_classes(mesh, triangles, std::move(guided.class_of_triangle), options,
                       std::move(facts), false, Keep::touching_road);
}

/// Whether there is a longer way round than along the road.
bool has_a_way_beside(const Cleaning& cleaning) {
  const RoadGraph graph = road_graph(surface_of(cleaning.soup));
  const std::vector<RoadWay> ways = road_ways(graph, 0.0, 4);
  return !ways.empty() && main_way(graph, ways).length_m < ways.front().length_m;
}

/// A line that names did not confirm tells what looks like road: with it as the guide, the parts of
/// the road that were missed come in, and what only lay beside it goes. Where that does not work,
/// and where names shall not count, the first look stands.
void look_again(const Mesh& mesh, const Triangles& triangles, const CleanOptions& options,
                Cleaning& cleaning) {
  if (options.use_names == UseNames::no || !has_several_looks(mesh)) return;
  try {
    const Centreline line = trace_centreline(road_mesh_of(mesh, cleaning));
    if (!line.closed) return;  // doubted anyway
    CleanReport facts;
    facts.triangles_in = cleaning.facts.triangles_in;
    facts.weld_tolerance_m = cleaning.facts.weld_tolerance_m;
    facts.snap_tolerance_m = cleaning.facts.snap_tolerance_m;
    facts.road_agreement = cleaning.facts.road_agreement;
    facts.remarks = cleaning.facts.remarks;
    Cleaning again =
        clean_along(mesh, {line.points_m, line.closed}, triangles, options, std::move(facts));
    if (!again.facts.doubts.empty()) return;
    again.soup.compact();
    if (has_a_way_beside(again) && !has_a_way_beside(cleaning)) return;  // another road came in
    const Centreline line_again = trace_centreline(road_mesh_of(mesh, again));
    const bool detours = line_again.length_m > kDetour * line.length_m;
    if (!line_again.closed || detours || !goes_along(line_again, line) ||
        !goes_along(line, line_again))
      return;
    again.facts.by_guide = false;
    again.facts.by_names = cleaning.facts.by_names;
    cleaning = std::move(again);
  } catch (const Error&) {  // trace_centreline() will say so to the user
  }
}

/// The way of the options' route over the roads by names, else over those by shape.
Guide guide_through(const Mesh& mesh, const CleanOptions& options) {
  std::optional<Error> refused;
  for (const Roads& roads : roads_of(mesh, options)) {
    try {
      return guide_of(straight_through_forks(RaySurface(roads.surface), roads.graph,
                                             way_through(roads.graph, options.route_m)));
    } catch (const Error& error) {
      if (!refused) refused = error;
    }
  }
  throw refused ? *refused
                : Error(
                      "nothing looks like road: a route has nothing to lead over; give a line "
                      "(--guide FILE)");
}

}  // namespace

std::vector<Roads> roads_of(const Mesh& mesh, const CleanOptions& options) {
  const Triangles triangles = look_at(mesh, options);
  std::vector<Roads> found;
  const auto add = [&](std::vector<SurfaceClass> classes) {
    try {
      Roads roads;
      roads.surface = surface_of(
          clean_classes(mesh, triangles, std::move(classes), options, {}, false, Keep::all).soup);
      roads.graph = road_graph(roads.surface);
      if (!roads.graph.branches.empty()) found.push_back(std::move(roads));
    } catch (const Error&) {  // no road of this kind
    }
  };
  if (options.use_names != UseNames::no && triangles.has_named_road) add(triangles.by_names);
  if (options.use_names != UseNames::yes)
    add(classes_by_shape(mesh, triangles.empty, triangles.flat, options).of_triangle);
  return found;
}

RoadMesh clean(const Mesh& mesh, const CleanOptions& options, CleanReport* report) {
  if (options.guide && !options.route_m.empty())
    throw Error(
        "a guide and a route seen; both tell which road is meant: give one of them (--guide, "
        "--route)");
  if (options.guide_width_m && !options.guide && options.route_m.empty())
    throw Error(
        "guide_width_m seen without a guide; it is the width of the road along one: give --guide "
        "FILE too");
  CleanReport facts;
  facts.triangles_in = mesh.triangles.size();
  facts.weld_tolerance_m = options.weld_tolerance_m;
  facts.snap_tolerance_m = options.snap_tolerance_m;

  Triangles triangles = look_at(mesh, options);
  const std::optional<Guide> guide =
      options.guide || options.route_m.empty() ? options.guide : guide_through(mesh, options);
  ClassesByShape by_shape;
  if (!guide) by_shape = classes_by_shape(mesh, triangles.empty, triangles.flat, options);
  if (!guide && options.use_names != UseNames::no && triangles.has_named_road) {
    facts.by_names = true;
    facts.road_agreement =
        agreement(mesh, triangles.by_names, by_shape.of_triangle, triangles.flat);
  }
  Cleaning cleaning;
  if (guide) {
    cleaning = clean_along(mesh, *guide, triangles, options, std::move(facts));
  } else if (!facts.by_names) {
    cleaning = clean_by_shape(mesh, triangles, std::move(by_shape.of_triangle), options, facts);
    cleaning.soup.compact();
    look_again(mesh, triangles, options, cleaning);
  } else if (options.use_names == UseNames::yes || options.near_m ||
             *facts.road_agreement >= kNamesAreRight || is_all_road(mesh, triangles)) {
    cleaning = clean_classes(mesh, triangles, triangles.by_names, options, std::move(facts), false);
  } else {
    cleaning = more_plausible(mesh, triangles, std::move(by_shape.of_triangle), options, facts);
    cleaning.soup.compact();
    look_again(mesh, triangles, options, cleaning);
  }
  Soup& soup = cleaning.soup;
  facts = std::move(cleaning.facts);
  if (!guide && !facts.by_names && facts.doubts.empty() && !by_shape.doubt.empty())
    facts.doubts.push_back(by_shape.doubt);
  soup.compact();
  facts.non_manifold_edges = adjacency(soup.triangles).non_manifold_edges;
  facts.boundary_loops = count_borders(soup.triangles);

  RoadMesh road = road_mesh_of(mesh, cleaning);
  road.guide = guide;
  facts.class_of_triangle = std::move(cleaning.class_of_triangle);
  for (const SurfaceClass surface_class : road.class_of_triangle)
    ++facts.kept[to_string(surface_class)];
  facts.triangles_kept = road.mesh.triangles.size();
  if (report != nullptr) *report = std::move(facts);
  return road;
}

}  // namespace road
