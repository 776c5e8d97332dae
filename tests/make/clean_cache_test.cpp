#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "make/make_track.h"
#include "mesh/export_mesh.h"
#include "support/strip_road.h"
#include "support/temporary_folder.h"

namespace clean_cache_test {

using road::Reuse;

/// 54,000 triangles: enough that their cleaning is kept.
std::string fine_mesh(const support::TemporaryFolder& folder) {
  road::RoadMesh strip = support::make_strip(
      support::straight, 150.0, 0.05, false, {-5, -4, -3, -2, -1, 0, 1, 2, 3, 5},
      [](double s, double v) { return 0.01 * s + 0.001 * v * v; });
  const std::string path = folder.path("fine.obj");
  road::export_mesh(strip.mesh, path);
  return path;
}

TEST(CleanCache, AMeshThatHasNotChangedIsNotCleanedAgain) {
  const support::TemporaryFolder folder;
  road::Recipe recipe = road::recipe_for_mesh(fine_mesh(folder));
  recipe.read.up = road::UpAxis::z;
  recipe.read.unit = road::Unit::m;
  recipe.reference_line.u_step_m = recipe.sample.v_step_m = 0.5;
  const auto build = [&](const road::Recipe& r, const std::string& out, Reuse reuse) {
    return road::make_track(r, folder.path(out), {}, nullptr, reuse);
  };
  EXPECT_FALSE(build(recipe, "out", Reuse::stages).clean_reused);

  road::Recipe smoother = recipe;
  smoother.smooth.window_u_m = 1.0;
  EXPECT_TRUE(build(smoother, "out", Reuse::stages).clean_reused);
  EXPECT_FALSE(build(smoother, "fresh", Reuse::stages).clean_reused);
  for (const char* file :
       {"fine.crg", "fine.stl", "fine.png", "fine.classes.png", "centreline.csv"})
    EXPECT_TRUE(folder.read(std::string("out/") + file) ==
                folder.read(std::string("fresh/") + file))
        << file;
  EXPECT_FALSE(build(smoother, "out", Reuse::nothing).clean_reused);

  road::Recipe other = recipe;
  other.clean.weld_tolerance_m = 0.002;
  EXPECT_FALSE(build(other, "out", Reuse::stages).clean_reused);
  other.clean.name_rules.insert(
      other.clean.name_rules.begin(),
      {road::NameRule::Field::object, "nothing", road::SurfaceClass::kerb});
  EXPECT_FALSE(build(other, "out", Reuse::stages).clean_reused);
  EXPECT_TRUE(build(other, "out", Reuse::stages).clean_reused);

  // Damage: cleaned again, and the file mended. That all damage is seen, Archive.* show.
  const std::string whole = folder.read("out/fine.clean.cache");
  std::string damaged = whole;
  damaged[whole.size() / 2] = static_cast<char>(damaged[whole.size() / 2] ^ 0x40);
  folder.file("out/fine.clean.cache", damaged);
  EXPECT_FALSE(build(other, "out", Reuse::stages).clean_reused);
  EXPECT_TRUE(folder.read("out/fine.clean.cache") == whole);
}

TEST(CleanCache, SmallMeshesLeaveNone) {
  const support::TemporaryFolder folder;
  const road::RoadMesh strip =
      support::make_strip(support::straight, 150.0, 1.0, false, {-5, 0, 5}, support::flat);
  road::export_mesh(strip.mesh, folder.path("small.obj"));
  road::Recipe recipe = road::recipe_for_mesh(folder.path("small.obj"));
  recipe.read.up = road::UpAxis::z;
  road::make_track(recipe, folder.path("out"), {}, nullptr, Reuse::stages);
  EXPECT_FALSE(std::filesystem::exists(folder.path("out/small.clean.cache")));
}

}  // namespace clean_cache_test
