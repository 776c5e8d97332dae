#include "make/objects.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mesh/export_mesh.h"
#include "support/ring_strips.h"
#include "support/temporary_folder.h"

namespace objects_test {

using ::testing::HasSubstr;

TEST(Objects, AreListedWithClassReasonAreaAndHeightAboveTheRoad) {
  support::TemporaryFolder folder;
  road::Mesh mesh;
  support::add_ring_strip(mesh, "plate", -2.0, 2.0, 3.5, 3.5);  // floats above the road
  support::add_ring_strip(mesh, "kerb", 5.0, 6.0, 0.0, 0.05);
  support::add_ring_strip(mesh, "road", -5.0, 5.0, 0.0, 0.0);
  const std::string path = folder.path("ring.obj");
  road::export_mesh(mesh, path);
  const road::ObjectTable table = road::objects_of(road::recipe_for_mesh(path));
  EXPECT_EQ(table.refusal, "");
  ASSERT_EQ(table.rows.size(), 3U);
  EXPECT_EQ(table.rows[0].object, "road");
  EXPECT_EQ(table.rows[0].surface_class, "road");
  EXPECT_THAT(table.rows[0].why, HasSubstr("object matches '"));
  EXPECT_NEAR(table.rows[0].area_m2, M_PI * (105.0 * 105.0 - 95.0 * 95.0), 1.0);
  EXPECT_NEAR(table.rows[0].above_road_m.value(), 0.0, 1e-4);
  EXPECT_EQ(table.rows[1].object, "kerb");
  EXPECT_EQ(table.rows[1].surface_class, "kerb");
  EXPECT_EQ(table.rows[2].object, "plate");
  EXPECT_EQ(table.rows[2].surface_class, "scenery");
  EXPECT_EQ(table.rows[2].why, "no rule matches");
  EXPECT_NEAR(table.rows[2].above_road_m.value(), 3.5, 1e-3);
}

TEST(Objects, OfAMeshThatIsRefusedAreListedToo) {
  support::TemporaryFolder folder;
  road::Mesh mesh;
  support::add_ring_strip(mesh, "tree", 5.0, 6.0, 0.0, 4.0);
  const std::string path = folder.path("tree.obj");
  road::export_mesh(mesh, path);
  road::Recipe recipe = road::recipe_for_mesh(path);
  recipe.read.up = road::UpAxis::z;
  const road::ObjectTable table = road::objects_of(recipe);
  EXPECT_NE(table.refusal, "");
  ASSERT_EQ(table.rows.size(), 1U);
  // No convention of names is known by its road.
  EXPECT_EQ(table.rows[0].surface_class, "unknown");
  EXPECT_EQ(table.rows[0].why, "no rule matches");
  EXPECT_FALSE(table.rows[0].above_road_m);
}

}  // namespace objects_test
