#include "clean_classes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "classify_by_shape.h"
#include "clean_layers.h"
#include "clean_soup.h"
#include "name_table.h"
#include "road/roads_of.h"

namespace road {
namespace {

// A steep face that rises this much from an edge is a wall, one that falls this much an edge of a
// bridge; kerbs are lower.
constexpr double kWallHeight_m = 0.25;
constexpr double kDropHeight_m = 0.5;
// Where geometry finds no road it looks again at a model this many times as large.
constexpr double kModelScale = 10.0;

/// The flat triangles as shape sees them, and which of the mesh they are.
struct FlatGround {
  FlatSurface surface;
  std::vector<std::uint32_t> source;
};

FlatGround flat_ground(const Mesh& mesh, const std::vector<bool>& empty,
                       const std::vector<bool>& flat, CleanOptions options) {
  std::vector<std::uint32_t> all;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (!empty[i]) all.push_back(i);
  }
  // Only to see what belongs together: welded coarsely, and surfaces may meet with a step as high
  // as a kerb. The mesh itself stays as it is.
  options.weld_tolerance_m = std::max(options.weld_tolerance_m, 0.01);
  CleanReport ignored;
  const std::vector<SurfaceClass> classes(mesh.triangles.size(), SurfaceClass::scenery);
  const Soup soup = make_soup(mesh, all, classes, options, ignored);
  Soup ground = soup;
  ground.filter([&](std::size_t i) { return flat[ground.source[i]]; });
  const std::vector<std::uint32_t> target = snap_borders(ground, kTouch_m, kWallHeight_m, ignored);
  FlatSurface surface;
  surface.vertices_m = std::move(ground.vertices_m);
  surface.triangles = std::move(ground.triangles);
  for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
    if (flat[soup.source[i]]) continue;
    const Triangle& t = soup.triangles[i];
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t a = t[c], b = t[(c + 1) % 3];
      const double edge_m = std::max(soup.vertices_m[a].z(), soup.vertices_m[b].z());
      const double apex_m = soup.vertices_m[t[(c + 2) % 3]].z();
      if (apex_m - edge_m < kWallHeight_m && edge_m - apex_m < kDropHeight_m) continue;
      const auto [low, high] = std::minmax(target[a], target[b]);
      surface.walls.push_back(static_cast<std::uint64_t>(low) << 32 | high);
    }
  }
  std::sort(surface.walls.begin(), surface.walls.end());
  return {std::move(surface), std::move(ground.source)};
}

}  // namespace

ClassesByShape classes_by_shape(const Mesh& mesh, const std::vector<bool>& empty,
                                const std::vector<bool>& flat, const CleanOptions& options) {
  auto [surface, source] = flat_ground(mesh, empty, flat, options);
  std::optional<StripPlace> place;
  if (options.near_m) place = {*options.near_m - mesh.origin_m.head<2>(), options.guide_width_m};
  ShapeClasses found = classify_by_shape(surface, place);
  const double scale = found.road_length_m == 0.0 ? kModelScale : 1.0;  // perhaps a model
  if (found.road_length_m == 0.0) {
    for (Eigen::Vector3d& v : surface.vertices_m) v *= kModelScale;
    if (place) place->at_m *= kModelScale;
    if (place && place->width_m) *place->width_m *= kModelScale;
    found = classify_by_shape(surface, place);
  }
  ClassesByShape classes{std::vector<SurfaceClass>(mesh.triangles.size(), SurfaceClass::scenery),
                         "", found.is_told};
  for (std::size_t i = 0; i < source.size(); ++i)
    classes.of_triangle[source[i]] = found.class_of_triangle[i];
  if (found.rival_width_m > 0.0)
    classes.doubt = fmt::format(
        "nothing is called road, and of two strips side by side the wider, of {:.1f} m, was taken; "
        "the other, of {:.1f} m, may be the road and this one its verge; say which by a rough line "
        "along it (--guide FILE), or, if the line is right all the same, with --line-is-right",
        found.road_width_m / scale, found.rival_width_m / scale);
  else if (found.in_one_plane_m > 0.0)
    classes.doubt = fmt::format(
        "nothing is called road, and by its shape it is {:.1f} m wide, of {:.1f} m in one plane: "
        "only the widths of columns tell them apart; say which by a rough line along it (--guide "
        "FILE), or, if the line is right all the same, with --line-is-right",
        found.road_width_m / scale, found.in_one_plane_m / scale);
  else if (found.twin_m) {
    const Eigen::Vector2d at_m = mesh.origin_m.head<2>() + *found.twin_m / scale;
    classes.doubt = fmt::format(
        "nothing is called road, and another strip as long and wide as the one taken, {:.1f} m, "
        "lies at ({:.1f}, {:.1f}); say which by a rough line along it (--guide FILE), or, if the "
        "line is right all the same, with --line-is-right",
        found.road_width_m / scale, at_m.x(), at_m.y());
  }
  return classes;
}

std::vector<PlaceOfRoad> places_that_may_be_road(const Mesh& mesh, const CleanOptions& options) {
  const Triangles triangles = look_at(mesh, options);
  FlatSurface surface = flat_ground(mesh, triangles.empty, triangles.flat, options).surface;
  std::vector<StripPlace> places = places_by_shape(surface);
  const double scale = places.empty() ? kModelScale : 1.0;
  if (places.empty()) {
    for (Eigen::Vector3d& v : surface.vertices_m) v *= kModelScale;
    places = places_by_shape(surface);
  }
  std::vector<PlaceOfRoad> found;
  for (const StripPlace& place : places) {
    found.push_back({mesh.origin_m.head<2>() + place.at_m / scale, place.width_m});
    if (found.back().width_m) *found.back().width_m /= scale;
  }
  return found;
}

double agreement(const Mesh& mesh, const std::vector<SurfaceClass>& a,
                 const std::vector<SurfaceClass>& b, const std::vector<bool>& flat) {
  double both_m2 = 0.0, either_m2 = 0.0;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const bool in_a = a[i] == SurfaceClass::road, in_b = b[i] == SurfaceClass::road;
    if (!flat[i] || (!in_a && !in_b)) continue;
    const double area_m2 =
        area_vector(mesh.vertex(i, 0), mesh.vertex(i, 1), mesh.vertex(i, 2)).norm();
    either_m2 += area_m2;
    if (in_a && in_b) both_m2 += area_m2;
  }
  return either_m2 > 0.0 ? both_m2 / either_m2 : 0.0;
}

Triangles look_at(const Mesh& mesh, const CleanOptions& options) {
  NameTable table(options.name_rules, convention_of(mesh.objects, options.name_rules));
  Triangles triangles;
  std::vector<SurfaceClass> class_of_object;
  class_of_object.reserve(mesh.objects.size());
  for (const MeshObject& object : mesh.objects) {
    const auto told = table.class_of(object);
    triangles.is_named.push_back(told.has_value());
    class_of_object.push_back(told.value_or(SurfaceClass::scenery));
  }
  const double min_cosine = std::cos(options.max_slope_deg * std::numbers::pi / 180.0);
  triangles.by_names.resize(mesh.triangles.size());
  triangles.flat.resize(mesh.triangles.size());
  triangles.empty.resize(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    triangles.by_names[i] = class_of_object[mesh.object_of_triangle[i]];
    const Eigen::Vector3d area =
        area_vector(mesh.vertex(i, 0), mesh.vertex(i, 1), mesh.vertex(i, 2));
    triangles.empty[i] = area.norm() < kZeroArea_m2;
    triangles.flat[i] = !triangles.empty[i] && std::abs(area.z()) >= min_cosine * area.norm();
  }
  const std::vector<bool> hidden =
      hidden_triangles(mesh, triangles.flat, class_of_object, triangles.remarks);
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (!hidden[i]) continue;
    triangles.left_out.push_back(i);
    triangles.by_names[i] = SurfaceClass::scenery;
    triangles.flat[i] = false;
    triangles.empty[i] = true;
  }
  triangles.has_named_road = std::find(class_of_object.begin(), class_of_object.end(),
                                       SurfaceClass::road) != class_of_object.end();
  return triangles;
}

bool is_all_road(const Mesh& mesh, const Triangles& triangles) {
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
    if (triangles.flat[i] && triangles.by_names[i] != SurfaceClass::road) return false;
  return true;
}

}  // namespace road
