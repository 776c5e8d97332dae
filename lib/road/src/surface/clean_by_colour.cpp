#include "clean_by_colour.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "colour_tone.h"
#include "mesh/ray_surface.h"
#include "road/road_graph.h"
#include "stations.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Flat ground of other colours, and between colours and greys, over that which is grey.
constexpr double kLeastOther = 0.1, kMostUnsure = 0.25;
// A plain road takes up this share of the surface, this slim or slimmer, and has ground of another
// colour along this share of each of its sides.
constexpr double kPlainShare = 0.8, kPlainSlimness = 0.1, kPlainSides = 0.6;
// Ground along this share of a side that is itself a ring, this wide beside the road, may be it.
constexpr double kRivalSide = 0.3, kRivalWidth = 0.6;
// Places beside the border, in half widths from the middle; and how much higher or lower, likewise.
constexpr double kBeside[] = {1.15, 1.4, 1.8}, kAsHigh = 0.5;
// One road told twice: this share of the one's area is in the other, and lengths agree within this.
constexpr double kSameRoad = 0.8, kSameLength = 0.05;
// So much of both areas is in both: nothing to tell.
constexpr double kSameSurface = 0.98;
constexpr double kWorthMuchMore = 1.5;  // worth of one road over another

double flat_area_m2(const Mesh& mesh, std::uint32_t t) {
  return 0.5 * std::abs(area_vector(mesh.vertex(t, 0), mesh.vertex(t, 1), mesh.vertex(t, 2)).z());
}

/// How much of each side of a way has coloured ground, and of which colours.
struct Sides {
  double poorer = 0.0;
  std::vector<std::uint32_t> groups;  ///< that lie along much of a side
};

Sides sides_of(const RoadWay& way, const Mesh& mesh, const Triangles& triangles,
               const std::vector<std::uint32_t>& groups) {
  Mesh ground;
  ground.origin_m = mesh.origin_m;
  ground.vertices_m = mesh.vertices_m;
  std::vector<std::uint32_t> group_of_triangle;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t object = mesh.object_of_triangle[t];
    if (!triangles.flat[t] || tone_of(mesh.objects[object].colour) != Tone::coloured) continue;
    ground.triangles.push_back(mesh.triangles[t]);
    group_of_triangle.push_back(groups[object]);
  }
  const RaySurface rays(ground);
  const std::size_t n = way.points_m.size();
  std::size_t with_ground[2] = {0, 0};
  std::vector<std::array<std::size_t, 2>> seen(mesh.objects.size(), {0, 0});
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t before = i > 0 ? i - 1 : way.closed ? n - 1 : 0;
    const std::size_t after = i + 1 < n ? i + 1 : way.closed ? 0 : i;
    const Vector2d along = (way.points_m[after] - way.points_m[before]).head<2>();
    const Vector2d left = Vector2d(-along.y(), along.x()).normalized();
    for (const std::size_t side : {0, 1}) {
      for (const double beside : kBeside) {
        const double offset_m = (side == 0 ? beside : -beside) * way.half_width_m[i];
        const Vector2d p = way.points_m[i].head<2>() + offset_m * left;
        const auto hit =
            rays.nearest_hit(p.x(), p.y(), way.points_m[i].z(), kAsHigh * way.half_width_m[i]);
        if (!hit) continue;
        ++with_ground[side];
        ++seen[group_of_triangle[hit->triangle]][side];
        break;
      }
    }
  }
  const auto all = static_cast<double>(n);
  Sides sides{static_cast<double>(std::min(with_ground[0], with_ground[1])) / all, {}};
  for (std::uint32_t group = 0; group < seen.size(); ++group)
    if (static_cast<double>(std::max(seen[group][0], seen[group][1])) > kRivalSide * all)
      sides.groups.push_back(group);
  return sides;
}

/// Whether the ground of one colour is itself a ring of road.
bool is_rival(std::uint32_t group, const std::vector<std::uint32_t>& groups, const RoadShown& road,
              const Mesh& mesh, const Triangles& triangles, const CleanOptions& options) {
  std::vector<SurfaceClass> classes(mesh.triangles.size(), SurfaceClass::scenery);
  for (std::uint32_t t = 0; t < classes.size(); ++t)
    if (triangles.flat[t] && groups[mesh.object_of_triangle[t]] == group)
      classes[t] = SurfaceClass::road;
  const auto cleaned = clean_classes(mesh, triangles, std::move(classes), options, {}, true);
  if (!cleaned) return false;  // none, or one along each side
  const RoadShown other = road_shown(cleaned->soup);
  return other.length_m > 0.0 && other.closed == road.closed && other.share > kPlainShare &&
         other.width_m < kPlainSlimness * other.length_m &&
         other.width_m > kRivalWidth * road.width_m;
}

/// Areas of the roads of two cleaned surfaces.
struct Overlap {
  double first_m2 = 0.0, second_m2 = 0.0, both_m2 = 0.0;
};

Overlap overlap_of(const Mesh& mesh, const Soup& first, const Soup& second) {
  std::vector<std::uint8_t> in(mesh.triangles.size(), 0);
  const auto mark = [&](const Soup& soup, std::uint8_t bit) {
    for (std::size_t i = 0; i < soup.triangles.size(); ++i)
      if (soup.surface_class[i] == SurfaceClass::road) in[soup.source[i]] |= bit;
  };
  mark(first, 1);
  mark(second, 2);
  Overlap overlap;
  for (std::uint32_t t = 0; t < in.size(); ++t) {
    if (in[t] == 0) continue;
    const double area_m2 = flat_area_m2(mesh, t);
    if ((in[t] & 1U) != 0) overlap.first_m2 += area_m2;
    if ((in[t] & 2U) != 0) overlap.second_m2 += area_m2;
    if (in[t] == 3) overlap.both_m2 += area_m2;
  }
  return overlap;
}

}  // namespace

std::optional<std::vector<SurfaceClass>> classes_by_colour(const Mesh& mesh,
                                                           const Triangles& triangles,
                                                           const CleanOptions& options) {
  if (options.use_names == UseNames::no || triangles.has_named_road) return std::nullopt;
  std::vector<Tone> tones;
  for (const MeshObject& object : mesh.objects) tones.push_back(tone_of(object.colour));
  double grey_m2 = 0.0, coloured_m2 = 0.0, unsure_m2 = 0.0;
  std::vector<SurfaceClass> classes(mesh.triangles.size(), SurfaceClass::scenery);
  for (std::uint32_t t = 0; t < classes.size(); ++t) {
    const std::uint32_t object = mesh.object_of_triangle[t];
    classes[t] = triangles.by_names[t];
    if (!triangles.flat[t]) continue;
    const double area_m2 = flat_area_m2(mesh, t);
    if (tones[object] == Tone::coloured) coloured_m2 += area_m2;
    if (triangles.is_named[object]) continue;
    if (tones[object] == Tone::grey) {
      grey_m2 += area_m2;
      classes[t] = SurfaceClass::road;
    } else if (tones[object] == Tone::coloured) {
      classes[t] = SurfaceClass::runoff;
    } else if (tones[object] == Tone::unsure) {
      unsure_m2 += area_m2;
    }
  }
  if (grey_m2 == 0.0 || coloured_m2 < kLeastOther * grey_m2 || unsure_m2 > kMostUnsure * grey_m2)
    return std::nullopt;
  return classes;
}

std::optional<ColouredRoad> road_by_colour(const Mesh& mesh, const Triangles& triangles,
                                           const CleanOptions& options, const CleanReport& facts) {
  auto classes = classes_by_colour(mesh, triangles, options);
  if (!classes) return std::nullopt;
  auto cleaned = clean_classes(mesh, triangles, std::move(*classes), options, facts, true);
  if (!cleaned) return std::nullopt;  // no road, or one along each side of the road
  std::optional<ColouredRoad> found(ColouredRoad{*std::move(cleaned), {}});
  const RoadGraph graph = road_graph(surface_of(found->cleaning.soup));
  const std::vector<RoadWay> ways = road_ways(graph, kRoadGap_m, 1);
  found->shown = road_shown(found->cleaning.soup);
  const RoadShown& shown = found->shown;
  if (ways.empty() || shown.share < kPlainShare || shown.width_m > kPlainSlimness * shown.length_m)
    return std::nullopt;
  const std::vector<std::uint32_t> groups = colour_groups(mesh.objects);
  const Sides sides = sides_of(ways[0], mesh, triangles, groups);
  if (sides.poorer < kPlainSides) return std::nullopt;
  for (const std::uint32_t group : sides.groups)
    if (is_rival(group, groups, shown, mesh, triangles, options)) return std::nullopt;
  found->cleaning.facts.by_colour = true;
  return found;
}

base::Answer<Cleaning> clean_by_colour_or_shape(const Mesh& mesh, const Triangles& triangles,
                                                ColouredRoad coloured, ClassesByShape by_shape,
                                                const CleanOptions& options,
                                                const CleanReport& facts) {
  auto shaped = clean_by_shape(mesh, triangles, std::move(by_shape.of_triangle), options, facts);
  const RoadShown &by_colour = coloured.shown,
                  by_form = shaped ? road_shown(shaped->soup) : RoadShown{};
  Overlap overlap;
  if (shaped) overlap = overlap_of(mesh, coloured.cleaning.soup, shaped->soup);
  const double either_m2 = overlap.first_m2 + overlap.second_m2 - overlap.both_m2;
  const bool is_doubted = !by_shape.doubt.empty() || (shaped && !shaped->facts.doubts.empty());
  if (shaped && !is_doubted && overlap.both_m2 > kSameSurface * either_m2) return shaped;
  const bool is_same =
      by_form.closed == by_colour.closed &&
      overlap.both_m2 > kSameRoad * std::min(overlap.first_m2, overlap.second_m2) &&
      std::abs(by_form.length_m - by_colour.length_m) < kSameLength * by_colour.length_m;
  const std::string both =
      fmt::format("by colour {}, {:.1f} m wide, by shape {}, {:.1f} m wide", text_of(by_colour),
                  by_colour.width_m, text_of(by_form), by_form.width_m);
  if (is_same || by_colour.worth() > kWorthMuchMore * by_form.worth()) {
    CleanReport& taken = coloured.cleaning.facts;
    taken.remarks.push_back(fmt::format(
        "road told by colour, since no name tells it: what is grey between ground of other "
        "colours; {}",
        shaped ? both + " (--use-names false takes the road by shape)" : "shape tells none"));
    if (!is_same && !by_colour.closed)
      taken.doubts.push_back(fmt::format(
          "colour alone tells the road, and it is open: {}; it may be a part of it", both));
    return std::move(coloured.cleaning);
  }
  if (by_form.worth() > kWorthMuchMore * by_colour.worth()) {
    shaped->facts.remarks.push_back(
        fmt::format("colour and shape disagree about what is road: {}; taken by shape", both));
    return shaped;
  }
  return base::Refusal(fmt::format(
      "no name tells what is road, and colour and shape tell different ones: {}", both));
}

}  // namespace road
