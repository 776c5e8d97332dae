#include "road/friction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/json_text.h"
#include "crg/surface.h"
#include "make/make_track.h"
#include "mesh/error.h"
#include "report/picture.h"
#include "support/run_crgbuild.h"
#include "support/temporary_folder.h"

namespace road {
namespace friction_test {

using ::testing::HasSubstr;

/// The stadium: 10 m of road with 3 m of grass on both sides, driven from (0, 0) towards +x.
TEST(Friction, ClassesAndZonesBecomeGripUnderTheWheels) {
  const support::TemporaryFolder folder;
  Recipe recipe = recipe_for_mesh(folder.file("s.obj", cli::Stadium{}.obj()));
  recipe.centreline.start_near_m = Eigen::Vector2d(0.0, 0.0);
  recipe.friction.wanted = true;
  recipe.friction.road = 0.98;
  recipe.friction.grass = 0.4;
  recipe.T_global_mesh.emplace();
  recipe.T_global_mesh->translation_m = {1000.0, 2000.0, 300.0};
  recipe.friction.zones_path = folder.file(
      "zones.csv",
      "u_begin_m,u_end_m,v_begin_m,v_end_m,friction\n50,60,-2,0,0.6\n300,10,-1,1,0.7\n");
  const BuildResult built = make_track(recipe, folder.path("out"));
  EXPECT_EQ(built.friction_path, folder.path("out/s.friction.crg"));
  crg::SurfaceOptions options;
  options.friction_map = crg::read(built.friction_path);
  const crg::Surface road(crg::read(built.crg_path), options);
  crg::Cursor cursor;
  const auto friction = [&](double x, double y) {
    return road.at_xy(1000.0 + x, 2000.0 + y, cursor).friction;
  };
  EXPECT_NEAR(friction(80.0, 0.0), 0.98, 1e-6);
  EXPECT_NEAR(friction(80.0, -4.8), 0.98, 1e-6);
  EXPECT_NEAR(friction(80.0, -5.3), 0.4, 1e-6);
  EXPECT_NEAR(friction(80.0, 6.5), 0.4, 1e-6);
  EXPECT_NEAR(friction(55.0, -1.0), 0.6, 1e-6);
  EXPECT_NEAR(friction(55.0, 1.0), 0.98, 1e-6);
  EXPECT_NEAR(friction(5.0, 0.5), 0.7, 1e-6);  // the zone that goes over the start
  const auto summary = base::parse_json<nlohmann::json>(built.summary_json)["friction"];
  EXPECT_EQ(summary["file"], "s.friction.crg");
  EXPECT_GT(summary["nodes"]["grass"].get<int>(), 1000);
  EXPECT_GT(summary["nodes"]["painted"].get<int>(), 1000);
  EXPECT_GT(summary["nodes"]["road"].get<int>(), 10'000);
}

TEST(Friction, AGreyPaintedOverThePictureOfClassesIsGrip) {
  const support::TemporaryFolder folder;
  Recipe recipe = recipe_for_mesh(folder.file("s.obj", cli::Stadium{}.obj()));
  recipe.centreline.start_near_m = Eigen::Vector2d(0.0, 0.0);
  const BuildResult first = make_track(recipe, folder.path("out"));
  EXPECT_TRUE(first.friction_path.empty());
  // Paints a wet patch of 20 m x 3 m in grey 55 at (60..80, -1.5..1.5), and one in blue, which is
  // no grip.
  report::Picture picture = report::decode_png(folder.read("out/s.classes.png"));
  std::istringstream world(folder.read("out/s.classes.pgw"));
  double a, d, b, e, c, f;
  world >> a >> d >> b >> e >> c >> f;
  for (int row = 0; row < picture.height_px; ++row) {
    for (int column = 0; column < picture.width_px; ++column) {
      const double x = c + a * column, y = f + e * row;
      std::uint8_t* p =
          &picture.rgba[4 * static_cast<std::size_t>(row * picture.width_px + column)];
      if (x > 60 && x < 80 && std::abs(y) < 1.5) p[0] = p[1] = p[2] = 55;
      if (x > 20 && x < 40 && std::abs(y) < 1.5) p[2] = 255;
    }
  }
  recipe.friction.wanted = true;
  recipe.friction.picture_path =
      folder.file("wet.png", report::encode_png(picture.width_px, picture.height_px, picture.rgba));
  try {
    make_track(recipe, folder.path("out"));
    FAIL() << "took a picture without a place";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("wet.png: no world file beside it (wet.pgw)"));
  }
  folder.file("wet.pgw", folder.read("out/s.classes.pgw"));
  recipe.T_global_mesh.emplace();
  recipe.T_global_mesh->translation_m = {1000.0, 0.0, 0.0};
  const BuildResult built = make_track(recipe, folder.path("out"));
  crg::SurfaceOptions options;
  options.friction_map = crg::read(built.friction_path);
  const crg::Surface road(crg::read(built.crg_path), options);
  crg::Cursor cursor;
  const auto friction = [&](double x, double y) {
    return road.at_xy(1000.0 + x, y, cursor).friction;
  };
  EXPECT_NEAR(friction(70.0, 0.0), 0.55, 1e-6);
  EXPECT_NEAR(friction(79.0, 1.2), 0.55, 1e-6);
  EXPECT_NEAR(friction(70.0, 2.5), 1.0, 1e-6);
  EXPECT_NEAR(friction(82.0, 0.0), 1.0, 1e-6);
  EXPECT_NEAR(friction(30.0, 0.0), 1.0, 1e-6);
  folder.file("wet.pgw", "1\n0\nx\n");
  EXPECT_THROW(read_friction_picture(*recipe.friction.picture_path), Error);
  folder.file("wet.pgw", "0\n0\n0\n0\n1\n1\n");
  EXPECT_THROW(read_friction_picture(*recipe.friction.picture_path), Error);
  folder.file("wet.pgw", "1\n0\n0\n-1\n0\n0\n");
  folder.file("wet.png", "no picture");
  EXPECT_THROW(read_friction_picture(*recipe.friction.picture_path), Error);
  // Before the mesh is even looked at.
  recipe.mesh_path = folder.path("none.obj");
  folder.file("none.obj", "no mesh");
  try {
    make_track(recipe, folder.path("refused"));
    FAIL() << "took a damaged picture";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("wet.png"), std::string::npos) << error.what();
  }
}

TEST(Friction, NamesTellConcreteAndGravelApart) {
  const support::TemporaryFolder folder;
  std::string obj = cli::Stadium{}.obj();
  // The run-off under another name.
  int renamed = 0;
  for (std::size_t at = 0; (at = obj.find("grass", at)) != std::string::npos; at += 6, ++renamed)
    obj.replace(at, 5, "gravel");
  ASSERT_GT(renamed, 0) << obj.substr(0, 400);
  Recipe recipe = recipe_for_mesh(folder.file("s.obj", obj));
  recipe.friction.wanted = true;
  const auto summary = base::parse_json<nlohmann::json>(
      make_track(recipe, folder.path("out")).summary_json)["friction"];
  EXPECT_GT(summary["nodes"]["gravel"].get<int>(), 1000);
  // Rays on the very border of the mesh meet no triangle; there the class decides.
  EXPECT_LT(summary["nodes"].value("grass", 0), summary["nodes"]["gravel"].get<int>() / 20);
}

TEST(Friction, ZonesAreRefusedWithTheirLine) {
  const support::TemporaryFolder folder;
  const auto refused = [&](const std::string& row) -> std::string {
    try {
      read_friction_zones(
          folder.file("z.csv", "u_begin_m,u_end_m,v_begin_m,v_end_m,friction\n" + row + "\n"));
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(refused("0,1,2,1,0.5"), HasSubstr("z.csv:2: v_begin_m 2"));
  EXPECT_THAT(refused("0,1,1,2,5"), HasSubstr("z.csv:2: friction is 5"));
  EXPECT_THAT(refused("0,1,1,,0.5"), HasSubstr("z.csv:2: column 'v_end_m' is empty, wanted"));
}

}  // namespace friction_test
}  // namespace road
