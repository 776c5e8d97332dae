#include "road/clean.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "base/statistics.h"
#include "classify_by_guide.h"
#include "clean_by_colour.h"
#include "clean_classes.h"
#include "cleaning.h"
#include "fork.h"
#include "mesh_topology.h"
#include "road/centreline.h"
#include "road/road_graph.h"
#include "road/roads_of.h"
#include "road/route.h"

namespace road {
namespace {

// Names that geometry confirms to this degree are believed without a second look.
constexpr double kNamesAreRight = 0.9;
// Of what lies beside a road, the road may have this share.
constexpr double kHardlyAny = 0.1;
// Rough ground is folded by this, and by this many times what the road is.
constexpr double kRoughFold = 0.005, kTimesRougher = 3.0;
// A second look that makes the road longer than this has gone astray at a wide place.
constexpr double kDetour = 1.01;

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
base::Answer<Cleaning> clean_along(const Mesh& mesh, const Guide& guide, const Triangles& triangles,
                                   const CleanOptions& options, CleanReport facts) {
  facts.by_guide = true;
  auto guided =
      classes_along(mesh, guide, options.guide_width_m, triangles.flat, triangles.by_names);
  if (!guided) return guided.refusal();
  facts.remarks.insert(facts.remarks.end(), guided->remarks.begin(), guided->remarks.end());
  facts.doubts = std::move(guided->doubts);
  return clean_classes(mesh, triangles, std::move(guided->class_of_triangle), options,
                       std::move(facts), false, Keep::touching_road);
}

/// Ways round beside the road: none, a longer one, or one that could be the road as well.
enum class WayBeside : std::uint8_t { none, longer, alike };

WayBeside way_beside(const Cleaning& cleaning) {
  const RoadGraph graph = road_graph(surface_of(cleaning.soup));
  const std::vector<RoadWay> ways = road_ways(graph, 0.0, 4);
  if (ways.empty()) return WayBeside::none;
  const auto way = main_way(graph, ways);
  if (!way) return WayBeside::alike;
  return way->length_m < ways.front().length_m ? WayBeside::longer : WayBeside::none;
}

/// The road along its own line, or nothing where that leads to another road or to none.
std::optional<Cleaning> along_its_line(const Mesh& mesh, const Triangles& triangles,
                                       const CleanOptions& options, const Cleaning& cleaning) {
  const auto line = try_trace_centreline(road_mesh_of(mesh, cleaning));
  if (!line || !line->closed) return std::nullopt;  // refused by others too, or doubted anyway
  CleanReport facts;
  facts.triangles_in = cleaning.facts.triangles_in;
  facts.weld_tolerance_m = cleaning.facts.weld_tolerance_m;
  facts.snap_tolerance_m = cleaning.facts.snap_tolerance_m;
  facts.road_agreement = cleaning.facts.road_agreement;
  facts.remarks = cleaning.facts.remarks;
  auto again =
      clean_along(mesh, {line->points_m, line->closed}, triangles, options, std::move(facts));
  if (!again || !again->facts.doubts.empty()) return std::nullopt;
  again->soup.compact();
  const WayBeside beside = way_beside(*again);
  if (beside == WayBeside::alike) return std::nullopt;
  if (beside == WayBeside::longer && way_beside(cleaning) != WayBeside::longer)
    return std::nullopt;  // another road came in
  const auto line_again = try_trace_centreline(road_mesh_of(mesh, *again));
  if (!line_again || !line_again->closed || line_again->length_m > kDetour * line->length_m ||
      !goes_along(*line_again, *line) || !goes_along(*line, *line_again))
    return std::nullopt;
  again->facts.by_guide = false;
  again->facts.by_names = cleaning.facts.by_names;
  return *std::move(again);
}

/// A line that names did not confirm tells what looks like road: with it as the guide, the parts of
/// the road that were missed come in, and what only lay beside it goes. Where that does not work,
/// and where names shall not count, the first look stands.
void look_again(const Mesh& mesh, const Triangles& triangles, const CleanOptions& options,
                Cleaning& cleaning) {
  if (options.use_names == UseNames::no || !has_several_looks(mesh)) return;
  if (auto again = along_its_line(mesh, triangles, options, cleaning)) cleaning = *std::move(again);
}

/// The road of a mesh whose names do not count: by colour or by shape.
base::Answer<Cleaning> clean_without_names(const Mesh& mesh, const Triangles& triangles,
                                           ClassesByShape by_shape, const CleanOptions& options,
                                           const CleanReport& facts) {
  if (auto coloured = road_by_colour(mesh, triangles, options, facts))
    return clean_by_colour_or_shape(mesh, triangles, *std::move(coloured), std::move(by_shape),
                                    options, facts);
  return clean_by_shape(mesh, triangles, std::move(by_shape.of_triangle), options, facts);
}

/// Whether most of what `wide` has beside `narrow` is made of something that `narrow` has hardly
/// any of: a verge, not another lane.
bool is_another_look(const Mesh& mesh, const Cleaning& wide, const Cleaning& narrow) {
  std::map<std::pair<std::string, std::string>, std::array<double, 2>> beside_and_on_m2;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (wide.class_of_triangle[t] != SurfaceClass::road) continue;
    const MeshObject& object = mesh.objects[mesh.object_of_triangle[t]];
    const bool on = narrow.class_of_triangle[t] == SurfaceClass::road;
    beside_and_on_m2[{object.material, object.texture}][on ? 1 : 0] +=
        area_vector(mesh.vertex(t, 0), mesh.vertex(t, 1), mesh.vertex(t, 2)).norm();
  }
  double all_m2 = 0.0, other_m2 = 0.0;
  for (const auto& [look, m2] : beside_and_on_m2) {
    all_m2 += m2[0];
    if (m2[1] < kHardlyAny * m2[0]) other_m2 += m2[0];
  }
  return other_m2 > 0.5 * all_m2;
}

/// Whether what `wide` has beside `narrow` is rough, as its triangles are folded against each
/// other.
bool is_rough_beside(const Cleaning& wide, const Cleaning& narrow) {
  const Soup& soup = wide.soup;
  std::array<std::vector<double>, 2> folds;  // beside, on
  const std::vector<EdgeUse> uses = edge_uses(soup.triangles);
  for (std::size_t i = 0; i + 1 < uses.size(); ++i) {
    if (uses[i].key != uses[i + 1].key) continue;
    const auto is_on = [&](const EdgeUse& use) {
      return narrow.class_of_triangle[soup.source[use.t]] == SurfaceClass::road;
    };
    if (is_on(uses[i]) != is_on(uses[i + 1])) continue;
    const Eigen::Vector3d a = soup.area_vector_of(uses[i].t).normalized(),
                          b = soup.area_vector_of(uses[i + 1].t).normalized();
    folds[is_on(uses[i]) ? 1 : 0].push_back(a.cross(b).norm());
  }
  return base::median_or(0.0, folds[0]) >
         kRoughFold + kTimesRougher * base::median_or(0.0, folds[1]);
}

/// Names that call everything road tell nothing apart, whatever it is made of: a doubt where colour
/// or shape show a closed road on it that is much narrower, between ground of another look, or
/// rough.
void doubt_names_of_all(const Mesh& mesh, const Triangles& triangles, ClassesByShape by_shape,
                        const CleanOptions& options, Cleaning& named) {
  CleanReport facts = named.facts;
  facts.by_names = false;
  const auto other = clean_without_names(mesh, triangles, std::move(by_shape), options, facts);
  if (!other) return;  // nothing else to choose
  const RoadShown all = road_shown(named.soup), narrow = road_shown(other->soup);
  if (narrow.closed && narrow.width_m < kLaneShare * all.width_m &&
      (is_another_look(mesh, named, *other) || is_rough_beside(named, *other)))
    named.facts.doubts.push_back(fmt::format(
        "names call all of the ground road, about {:.0f} m wide, and tell no verge from it; by {} "
        "the road is about {:.0f} m wide: take that with --use-names false, or all of it with "
        "--use-names true",
        all.width_m, other->facts.by_colour ? "colour" : "shape", narrow.width_m));
}

/// The road where nobody says which: by colour, by shape or by names.
base::Answer<Cleaning> clean_unguided(const Mesh& mesh, const Triangles& triangles,
                                      ClassesByShape by_shape, const CleanOptions& options,
                                      CleanReport facts) {
  const bool by_names = facts.by_names;
  const bool names_are_told = options.use_names == UseNames::yes || options.near_m;
  const bool is_all = by_names && is_all_road(mesh, triangles);
  if (by_names && (names_are_told || is_all || *facts.road_agreement >= kNamesAreRight)) {
    auto named =
        clean_classes(mesh, triangles, triangles.by_names, options, std::move(facts), false);
    // Where shape has nearly all of it too there is no narrower one.
    if (named && is_all && !names_are_told && named->facts.road_agreement < kNamesAreRight)
      doubt_names_of_all(mesh, triangles, std::move(by_shape), options, *named);
    return named;
  }
  auto cleaning =
      by_names ? more_plausible(mesh, triangles, std::move(by_shape.of_triangle), options, facts)
               : clean_without_names(mesh, triangles, std::move(by_shape), options, facts);
  if (!cleaning) return cleaning;
  cleaning->soup.compact();
  if (by_names ? !cleaning->is_sure : !cleaning->facts.by_colour)
    look_again(mesh, triangles, options, *cleaning);
  return cleaning;
}

/// The way of the options' route over the roads by names, else over those by shape.
base::Answer<Guide> guide_through(const Mesh& mesh, const CleanOptions& options) {
  std::optional<base::Refusal> refused;
  for (const Roads& roads : roads_of(mesh, options)) {
    auto way = way_through(roads.graph, options.route_m);
    auto guide = way ? guide_of(straight_through_forks(RaySurface(roads.surface), roads.graph,
                                                       *std::move(way)))
                     : way.refusal();
    if (guide) return guide;
    if (!refused) refused = guide.refusal();
  }
  if (refused) return *refused;
  return base::Refusal(
      "nothing looks like road: a route has nothing to lead over; give a line (--guide FILE)");
}

}  // namespace

std::vector<Roads> roads_of(const Mesh& mesh, const CleanOptions& options) {
  const Triangles triangles = look_at(mesh, options);
  std::vector<Roads> found;
  const auto add = [&](std::vector<SurfaceClass> classes) {
    const auto cleaned =
        clean_classes(mesh, triangles, std::move(classes), options, {}, false, Keep::all);
    if (!cleaned) return;  // no road of this kind
    Roads roads;
    roads.surface = surface_of(cleaned->soup);
    roads.graph = road_graph(roads.surface);
    if (!roads.graph.branches.empty()) found.push_back(std::move(roads));
  };
  if (options.use_names != UseNames::no && triangles.has_named_road) add(triangles.by_names);
  if (road_by_colour(mesh, triangles, options, {}))
    add(*classes_by_colour(mesh, triangles, options));
  if (options.use_names != UseNames::yes)
    add(classes_by_shape(mesh, triangles.empty, triangles.flat, options).of_triangle);
  return found;
}

base::Answer<RoadMesh> try_clean(const Mesh& mesh, const CleanOptions& options,
                                 CleanReport* report) {
  if (options.guide && !options.route_m.empty())
    return base::Refusal(
        "a guide and a route seen; both tell which road is meant: give one of them (--guide, "
        "--route)");
  if (options.guide_width_m && !options.guide && options.route_m.empty() && !options.near_m)
    return base::Refusal(
        "guide_width_m seen without a guide; it is the width of the road along one, or at "
        "--near-m: give --guide FILE too");
  CleanReport facts;
  facts.triangles_in = mesh.triangles.size();
  facts.weld_tolerance_m = options.weld_tolerance_m;
  facts.snap_tolerance_m = options.snap_tolerance_m;

  Triangles triangles = look_at(mesh, options);
  facts.remarks = triangles.remarks;
  std::optional<Guide> guide = options.guide;
  if (!guide && !options.route_m.empty()) {
    auto through = guide_through(mesh, options);
    if (!through) return through.refusal();
    guide = *std::move(through);
  }
  ClassesByShape by_shape;
  if (!guide) by_shape = classes_by_shape(mesh, triangles.empty, triangles.flat, options);
  if (!guide && options.use_names != UseNames::no && triangles.has_named_road) {
    facts.by_names = true;
    facts.road_agreement =
        agreement(mesh, triangles.by_names, by_shape.of_triangle, triangles.flat);
  }
  const std::string doubt = by_shape.doubt;
  facts.by_place = by_shape.is_told;
  auto cleaned =
      guide ? clean_along(mesh, *guide, triangles, options, std::move(facts))
            : clean_unguided(mesh, triangles, std::move(by_shape), options, std::move(facts));
  if (!cleaned) return cleaned.refusal();
  Cleaning& cleaning = *cleaned;
  Soup& soup = cleaning.soup;
  facts = std::move(cleaning.facts);
  if (!guide && !facts.by_names && !facts.by_colour && facts.doubts.empty() && !doubt.empty())
    facts.doubts.push_back(doubt);
  soup.compact();
  facts.boundary_loops = count_borders(soup.triangles);

  RoadMesh road = road_mesh_of(mesh, cleaning);
  road.guide = guide;
  facts.class_of_triangle = std::move(cleaning.class_of_triangle);
  facts.left_out = std::move(triangles.left_out);
  for (const SurfaceClass surface_class : road.class_of_triangle)
    ++facts.kept[to_string(surface_class)];
  facts.triangles_kept = road.mesh.triangles.size();
  if (report != nullptr) *report = std::move(facts);
  return road;
}

RoadMesh clean(const Mesh& mesh, const CleanOptions& options, CleanReport* report) {
  return try_clean(mesh, options, report).or_throw();
}

}  // namespace road
