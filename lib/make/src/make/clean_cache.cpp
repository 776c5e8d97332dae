#include "clean_cache.h"

#include <fmt/format.h>

#include <filesystem>

#include "base/archive.h"
#include "base/read_file.h"
#include "base/write_file.h"

namespace road {

template <typename Archive, typename Value>
requires std::is_same_v<std::remove_const_t<Value>, Guide>
void fields(Archive& archive, Value& guide) { archive(guide.points_m, guide.closed); }

namespace {

constexpr std::size_t kLargestCache = 4'000'000'000;
constexpr base::ArchiveKind kCleanedMesh{"kerbstone cleaned mesh", 3};

/// Every value of a cleaned mesh, for both directions.
template <typename Archive, typename Value>
void each(Archive& a, Value& cleaned) {
  auto& [road, r] = cleaned;
  a(road.mesh.origin_m), a(road.mesh.vertices_m), a(road.mesh.triangles),
      a(road.mesh.object_of_triangle), a(road.mesh.objects);
  a(road.class_of_triangle), a(road.guide);
  a(r.triangles_in), a(r.triangles_kept), a(r.dropped), a(r.kept), a(r.vertices_welded),
      a(r.weld_tolerance_m), a(r.vertices_snapped);
  a(r.snap_tolerance_m), a(r.faces_turned), a(r.bridging_triangles), a(r.bridged_m),
      a(r.holes_closed), a(r.holes_closed_m2), a(r.non_manifold_edges), a(r.boundary_loops),
      a(r.components);
  a(r.by_names), a(r.by_colour), a(r.by_guide), a(r.by_place), a(r.doubts), a(r.road_agreement),
      a(r.is_all_by_names), a(r.class_of_triangle), a(r.left_out), a(r.remarks);
}

bool is_whole(const Mesh& mesh, const std::vector<SurfaceClass>& class_of_triangle) {
  if (mesh.object_of_triangle.size() != mesh.triangles.size() ||
      class_of_triangle.size() != mesh.triangles.size())
    return false;
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle)
      if (corner >= mesh.vertices_m.size()) return false;
  for (const std::uint32_t object : mesh.object_of_triangle)
    if (object >= mesh.objects.size()) return false;
  return true;
}

}  // namespace

std::string clean_key(const Recipe& recipe, const std::optional<Guide>& guide,
                      const TiltAndScale& tilt_and_scale, const std::string& program,
                      const std::vector<InputFile>& mesh_files) {
  std::string key = program + "\n";
  for (const InputFile& file : mesh_files)
    key += fmt::format("{} {} {}\n", file.role, file.path, file.sha256);
  if (guide) {
    key += guide->closed ? "closed guide" : "open guide";
    for (const Eigen::Vector3d& p : guide->points_m)
      key += fmt::format(" {},{},{}", p.x(), p.y(), p.z());
    key += "\n";
  }
  if (!tilt_and_scale.is_identity()) {
    for (const double value : tilt_and_scale.about_m) key += fmt::format("about {}\n", value);
    for (const double value : tilt_and_scale.linear.reshaped())
      key += fmt::format("linear {}\n", value);
  }
  for (const RecipeKey& k : recipe_keys())
    if (k.stage == "read" || k.stage == "clean")
      key += fmt::format("{} {}\n", k.name, k.show(recipe));
  for (const NameRule& rule : recipe.clean.name_rules)
    key += fmt::format("rule {} {} {} {}\n", static_cast<int>(rule.field), rule.pattern,
                       to_string(rule.surface_class), rule.convention);
  return key;
}

void write_clean_cache(const Cleaned& cleaned, const std::string& key, const std::string& path) {
  base::ArchiveWriter writer(kCleanedMesh);
  writer(key);
  each(writer, cleaned);
  base::write_file(path, writer.finish());
}

std::optional<Cleaned> read_clean_cache(const std::string& key, const std::string& path) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  const auto file = base::try_read_file(path, kLargestCache);
  if (!file) return std::nullopt;  // it can be made again
  base::ArchiveReader reader(*file, kCleanedMesh);
  std::string key_there;
  reader(key_there);
  if (!reader.good() || key_there != key) return std::nullopt;
  Cleaned cleaned;
  each(reader, cleaned);
  if (!reader.finish() || !is_whole(cleaned.road.mesh, cleaned.road.class_of_triangle))
    return std::nullopt;
  return cleaned;
}

}  // namespace road
