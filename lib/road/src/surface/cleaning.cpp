#include "cleaning.h"

#include <fmt/format.h>

#include "clean_gaps.h"
#include "clean_layers.h"
#include "clean_parts.h"
#include "corner_holes.h"
#include "mesh_topology.h"
#include "road/road_graph.h"
#include "strip_ends.h"

namespace road {
namespace {

// Vertices snapped at a border must agree in height, or the lip of a kerb would be flattened.
constexpr double kSnapHeight_m = 0.001;
constexpr double kTornHeight_m = 0.005;
// Of a gap that a bridge of another name may span, and of the road's border at its ends.
constexpr double kLongestBridge_m = 100.0, kWidestBorder_m = 60.0;

bool has_far_gap(const Soup& soup) {
  return !facing_ends(open_ends(road_triangles(soup), soup.vertices_m, kWidestBorder_m),
                      kLongestBridge_m)
              .empty();
}

}  // namespace

std::string told_by(const CleanReport& report) {
  return report.by_guide    ? "the guide"
         : report.by_names  ? "names"
         : report.by_colour ? "colour"
                            : "shape";
}

base::Answer<Cleaning> clean_classes(const Mesh& mesh, const Triangles& triangles,
                                     std::vector<SurfaceClass> class_of_triangle,
                                     const CleanOptions& options, CleanReport facts, bool doubtful,
                                     Keep keep) {
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
  if (facts.by_names) cut_strokes(mesh, triangles.flat, options, class_of_triangle, facts);
  CleanReport first = facts;
  Soup soup = build_soup(first);
  if (keep == Keep::one &&
      fill_gaps_from_other_names(mesh, soup, triangles.flat, class_of_triangle, facts)) {
    first = facts;
    soup = build_soup(first);
  }
  // Where names are right, a bridge is what no rule of theirs tells.
  std::vector<bool> unnamed = triangles.flat;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
    unnamed[i] = unnamed[i] && !triangles.is_named[mesh.object_of_triangle[i]];
  if (keep == Keep::one && facts.by_names &&
      fill_gaps_from_end_to_end(mesh, soup, unnamed, options, class_of_triangle, facts)) {
    first = facts;
    soup = build_soup(first);
  }
  facts = std::move(first);
  std::vector<Bridge> bridges;
  const bool by_names = !doubtful && keep == Keep::one && facts.by_names && has_far_gap(soup);
  if (doubtful || by_names)
    bridges = fill_gaps_between_ends(mesh, road_graph(surface_of(soup)),
                                     by_names ? unnamed : triangles.flat, class_of_triangle, facts);
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
  close_corner_holes(mesh, triangles.flat, soup, options, facts);
  bridge_gaps(
      soup, [](std::size_t) { return true; }, mesh.origin_m, options, facts);
  bridge_gaps(
      soup, [&](std::size_t i) { return soup.surface_class[i] == SurfaceClass::road; },
      mesh.origin_m, options, facts);
  if (keep == Keep::touching_road) keep_what_touches_road(soup, facts);
  if (keep == Keep::one)
    if (auto several = keep_one_circuit(soup, bridges, mesh.origin_m, options, facts))
      return *std::move(several);
  if (soup.triangles.empty()) {
    return base::Refusal(
        fmt::format("nothing to drive on: {} triangles in {} objects, none of them road; give a "
                    "mesh with a road, "
                    "or name rules that find it",
                    mesh.triangles.size(), mesh.objects.size()));
  }
  return Cleaning{std::move(soup), std::move(facts), std::move(class_of_triangle), false};
}

}  // namespace road
