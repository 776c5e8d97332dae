#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <unordered_set>
#include <vector>

#include "clean_gaps.h"

namespace road {
namespace {

// Of the area that names call road: objects that hold less are looked at as strokes, where all
// others hold nearly everything.
constexpr double kSmallShare = 0.02, kMainShare = 0.9;

/// The triangles that names call road of objects with little of it.
std::vector<std::uint32_t> of_small_objects(const Mesh& mesh,
                                            const std::vector<SurfaceClass>& class_of_triangle) {
  std::vector<double> road_m2(mesh.objects.size(), 0.0);
  double all_m2 = 0.0;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (class_of_triangle[i] != SurfaceClass::road) continue;
    const double area_m2 =
        area_vector(mesh.vertex(i, 0), mesh.vertex(i, 1), mesh.vertex(i, 2)).norm();
    road_m2[mesh.object_of_triangle[i]] += area_m2;
    all_m2 += area_m2;
  }
  double main_m2 = 0.0;
  for (const double m2 : road_m2)
    if (m2 >= kSmallShare * all_m2) main_m2 += m2;
  std::vector<std::uint32_t> small;
  if (main_m2 < kMainShare * all_m2) return small;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
    if (class_of_triangle[i] == SurfaceClass::road &&
        road_m2[mesh.object_of_triangle[i]] < kSmallShare * all_m2)
      small.push_back(i);
  return small;
}

}  // namespace

void cut_strokes(const Mesh& mesh, const std::vector<bool>& flat, const CleanOptions& options,
                 std::vector<SurfaceClass>& class_of_triangle, CleanReport& facts) {
  const std::vector<std::uint32_t> small = of_small_objects(mesh, class_of_triangle);
  if (small.empty()) return;
  std::vector<SurfaceClass> without = class_of_triangle;
  for (const std::uint32_t i : small) without[i] = SurfaceClass::scenery;
  std::vector<std::uint32_t> kept;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
    if (without[i] == SurfaceClass::road && flat[i]) kept.push_back(i);
  CleanReport counted;
  const Soup rest = make_soup(mesh, kept, without, options, counted);
  std::vector<bool> may_fill(mesh.triangles.size(), false);
  for (const std::uint32_t i : small) may_fill[i] = flat[i];
  if (!fill_gaps_from_other_names(mesh, rest, may_fill, without, counted)) return;

  // What hangs together with a piece that fills a gap, and does not lie in it, sticks out.
  const Soup strokes = make_soup(mesh, small, class_of_triangle, options, counted);
  const std::vector<std::uint32_t> component = components(strokes.triangles).of_triangle;
  std::unordered_set<std::uint32_t> filling;
  for (std::size_t k = 0; k < strokes.source.size(); ++k)
    if (without[strokes.source[k]] == SurfaceClass::road) filling.insert(component[k]);
  std::size_t cut = 0;
  for (std::size_t k = 0; k < strokes.source.size(); ++k) {
    const std::uint32_t i = strokes.source[k];
    if (without[i] == SurfaceClass::road || !filling.contains(component[k])) continue;
    class_of_triangle[i] = SurfaceClass::scenery;
    if (cut++ == 0)
      facts.remarks.push_back(fmt::format(
          "object '{0}'{1} lies across gaps of the road and sticks out of it: what lies beyond the "
          "edges of the road was left out",
          mesh.objects[mesh.object_of_triangle[i]].name,
          mesh.objects[mesh.object_of_triangle[i]].material.empty()
              ? ""
              : fmt::format(" (material '{}')",
                            mesh.objects[mesh.object_of_triangle[i]].material)));
  }
}

}  // namespace road
