#include "make/make_road.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "crg/file.h"
#include "crg/surface.h"
#include "mesh/error.h"
#include "mesh/export_mesh.h"
#include "support/ring_strips.h"
#include "support/strip_road.h"
#include "support/temporary_folder.h"

namespace make_road_test {

double height_m(double s, double v) { return 0.02 * s + 0.001 * v * v; }

road::Recipe strip_recipe(const support::TemporaryFolder& folder) {
  const road::RoadMesh strip = support::make_strip(support::straight, 150.0, 0.5, false,
                                                   {-4, -3, -2, -1, 0, 1, 2, 3, 4}, height_m);
  road::export_mesh(strip.mesh, folder.path("strip.obj"));
  road::Recipe recipe = road::recipe_for_mesh(folder.path("strip.obj"));
  recipe.read.up = road::UpAxis::z;
  recipe.read.unit = road::Unit::m;
  recipe.line_is_right = true;
  return recipe;
}

TEST(Built, HoldsTheRoadAndNothingIsWritten) {
  const support::TemporaryFolder folder;
  const road::Recipe recipe = strip_recipe(folder);
  const auto inputs = road::inputs_of(recipe);
  ASSERT_EQ(inputs.size(), 1u);
  EXPECT_EQ(inputs[0].role, "mesh");
  const auto before = std::distance(std::filesystem::directory_iterator(folder.path("")), {});
  const road::MadeRoad built = road::make_road(recipe, inputs, {});
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path("")), {}), before);
  EXPECT_FALSE(built.before.has_value());
  EXPECT_FALSE(built.friction.has_value());
  EXPECT_NEAR(built.centreline.length_m, 150.0, 1.0);
  EXPECT_TRUE(built.summary.outputs.empty());
  const auto& grid = built.sampled.grid;
  std::size_t with_z = 0;
  for (const float z : grid.z_m) with_z += std::isfinite(z);
  EXPECT_GT(with_z, grid.z_m.size() / 3);
}

TEST(Built, IsWrittenAsItStandsAndCheckedByReadingItBack) {
  const support::TemporaryFolder folder;
  const road::Recipe recipe = strip_recipe(folder);
  road::MadeRoad built = road::make_road(recipe, road::inputs_of(recipe), {});
  const double u_m = built.line.u_begin_m + 100.0 * built.line.u_step_m;
  base::OutputSet outputs(folder.path("out"), road::kBuildCommand);
  const road::BuildResult result = road::write(built, outputs);
  EXPECT_FALSE(std::filesystem::exists(result.crg_path)) << "before the commit";
  outputs.commit(recipe.name);
  const crg::Surface surface(crg::read(result.crg_path));
  const auto at = surface.at_uv(u_m, 2.0);
  // The straight runs along x or against it; its middle has v = 0. Facets of 1 m sag by 0.25 mm.
  EXPECT_NEAR(at.z_m, height_m(at.x_m, 2.0), 0.0003);
  EXPECT_TRUE(result.validation_failures.empty());
  EXPECT_EQ(built.summary.outputs.size(), 5u);
}

// A gantry stands over the road, and nobody drives on it.
TEST(Built, StartsAtAnyObjectOfTheMesh) {
  const support::TemporaryFolder folder;
  road::Mesh mesh;
  support::add_ring_strip(mesh, "road", -4.5, 4.5, 0.0, 0.0);
  support::add_ring_strip(mesh, "Start/Finish", 6.0, 8.0, 3.0, 3.0, 100.0, 102.0);
  road::export_mesh(mesh, folder.path("ring.obj"), {road::UpAxis::z, road::Unit::m});
  road::Recipe recipe = road::recipe_for_mesh(folder.path("ring.obj"));
  recipe.read.up = road::UpAxis::z;
  recipe.read.unit = road::Unit::m;
  recipe.start_object = "Start/Finish";
  const road::MadeRoad built = road::make_road(recipe, road::inputs_of(recipe), {});
  const Eigen::Vector3d wanted = support::on_ring(101.0, 0.0, 0.0);
  EXPECT_NEAR(built.line.x_m[0], wanted.x(), 0.5);
  EXPECT_NEAR(built.line.y_m[0], wanted.y(), 0.5);

  recipe.start_object = "nothing";
  EXPECT_THAT([&] { road::make_road(recipe, road::inputs_of(recipe), {}); },
              ::testing::ThrowsMessage<road::Error>(
                  ::testing::HasSubstr("no object named 'nothing'; 'crgbuild objects MESH'")));
}

}  // namespace make_road_test
