#include "make/objects.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "make/place.h"
#include "mesh/ray_surface.h"
#include "mesh/read_mesh.h"
#include "road/clean.h"

namespace road {
namespace {

constexpr std::size_t kHeights = 400;  // looked at of one object
constexpr double kReach_m = 50.0;
constexpr std::size_t kSurfaceClasses = 5;

/// The triangles that were taken for road.
Mesh road_of(const Mesh& mesh, const std::vector<SurfaceClass>& classes) {
  Mesh road;
  road.origin_m = mesh.origin_m;
  road.vertices_m = mesh.vertices_m;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (classes[t] == SurfaceClass::road) road.triangles.push_back(mesh.triangles[t]);
  return road;
}

std::optional<double> height_above(const RaySurface& road, const Mesh& mesh,
                                   const std::vector<std::uint32_t>& triangles) {
  std::vector<double> heights_m;
  const std::size_t step = std::max<std::size_t>(1, triangles.size() / kHeights);
  for (std::size_t k = 0; k < triangles.size(); k += step) {
    const Eigen::Vector3d place =
        mesh.origin_m + (mesh.vertex(triangles[k], 0) + mesh.vertex(triangles[k], 1) +
                         mesh.vertex(triangles[k], 2)) /
                            3.0;
    const auto hit = road.nearest_hit(place.x(), place.y(), place.z(), kReach_m);
    if (hit) heights_m.push_back(place.z() - hit->z_m);
  }
  if (heights_m.empty()) return std::nullopt;
  const auto middle = heights_m.begin() + static_cast<std::ptrdiff_t>(heights_m.size() / 2);
  std::nth_element(heights_m.begin(), middle, heights_m.end());
  return *middle;
}

std::string words_of(const NameRule& rule) {
  constexpr std::array kFields{"object", "material", "texture"};
  return fmt::format("{} matches '{}'", kFields[static_cast<std::size_t>(rule.field)],
                     rule.pattern);
}

std::vector<std::vector<std::uint32_t>> triangles_of_objects(const Mesh& mesh) {
  std::vector<std::vector<std::uint32_t>> out(mesh.objects.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    out[mesh.object_of_triangle[t]].push_back(t);
  return out;
}

/// Sets area, and the class of most of it where cleaning said one.
void measure(const Mesh& mesh, const std::vector<std::uint32_t>& triangles,
             const std::vector<SurfaceClass>& classes, ObjectRow& row) {
  std::array<double, kSurfaceClasses> area_m2{};
  for (const std::uint32_t t : triangles) {
    const Eigen::Vector3d& a = mesh.vertex(t, 0);
    const double m2 = 0.5 * (mesh.vertex(t, 1) - a).cross(mesh.vertex(t, 2) - a).norm();
    row.area_m2 += m2;
    if (!classes.empty()) area_m2[static_cast<std::size_t>(classes[t])] += m2;
  }
  if (classes.empty()) return;
  const auto most = std::max_element(area_m2.begin(), area_m2.end()) - area_m2.begin();
  row.surface_class = to_string(static_cast<SurfaceClass>(most));
}

std::size_t order_of(const std::string& surface_class) {
  std::size_t place = 0;
  while (place < kSurfaceClasses && surface_class != to_string(static_cast<SurfaceClass>(place)))
    ++place;
  return place;
}

}  // namespace

ObjectTable objects_of(const Recipe& recipe) {
  ObjectTable out;
  MeshReadReport read;
  const Mesh mesh = read_mesh(recipe.mesh_path, read_to_clean(recipe.read, recipe.clean), &read);
  const auto told = report_of_cleaning(recipe, mesh);
  const CleanReport report = told ? *told : CleanReport{};
  const std::string by = told ? told_by(report) : "";
  const std::vector<SurfaceClass>& classes = report.class_of_triangle;
  const auto rules = rules_of(mesh.objects, recipe.clean.name_rules);
  const auto triangles = triangles_of_objects(mesh);
  std::optional<RaySurface> road;
  if (!classes.empty()) road.emplace(road_of(mesh, classes));
  for (std::size_t k = 0; k < mesh.objects.size(); ++k) {
    ObjectRow row{mesh.objects[k].name, mesh.objects[k].material, "unknown", by, 0, 0.0, {}};
    const NameRule* rule = rules[k] ? &recipe.clean.name_rules[*rules[k]] : nullptr;
    if (rule != nullptr) row.surface_class = to_string(rule->surface_class);
    if (report.by_names || classes.empty())
      row.why = rule != nullptr ? words_of(*rule) : "no rule matches";
    row.triangles = triangles[k].size();
    measure(mesh, triangles[k], classes, row);
    if (road) row.above_road_m = height_above(*road, mesh, triangles[k]);
    out.rows.push_back(std::move(row));
  }
  std::stable_sort(out.rows.begin(), out.rows.end(), [](const ObjectRow& a, const ObjectRow& b) {
    const std::size_t first = order_of(a.surface_class), second = order_of(b.surface_class);
    return first != second ? first < second : a.area_m2 > b.area_m2;
  });
  out.up = read.up;
  out.unit = read.unit;
  if (!told) out.refusal = told.refusal().message;
  out.remarks = read.remarks;
  out.remarks.insert(out.remarks.end(), report.remarks.begin(), report.remarks.end());
  return out;
}

}  // namespace road
