// Cracks are closed; a wall whose foot the ground leaves out ends the surface, what only hangs over
// a gap does not.
#include "road/gaps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "crg/surface.h"
#include "make/make_track.h"
#include "mesh/export_mesh.h"
#include "support/ring_strips.h"
#include "support/temporary_folder.h"

namespace gaps_test {

using support::add_ring_strip;

/// Road to 5 m, grass to 9 m; the grass has a crack of 0.2 m at 6.04 m on the left over s = 100 to
/// 400 m.
road::Mesh cracked_ring() {
  road::Mesh mesh;
  add_ring_strip(mesh, "TKMN1", -5.0, 5.0, 0.0, 0.0);
  add_ring_strip(mesh, "TKRS1", -9.0, -5.0, 0.0, 0.0);
  add_ring_strip(mesh, "TKLS1", 5.0, 6.04, 0.0, 0.0);
  add_ring_strip(mesh, "TKLS2", 6.24, 9.0, 0.0, 0.0, 100.0, 400.0);
  add_ring_strip(mesh, "TKLS3", 6.04, 9.0, 0.0, 0.0, 400.0, support::kRingLength_m + 100.0);
  return mesh;
}

struct Built {
  crg::Surface road;
  nlohmann::json summary;
  bool has_height(double s_m, double left_m) const {
    const Eigen::Vector3d p = support::on_ring(s_m, left_m, 0.0);
    crg::Cursor cursor;
    return !std::isnan(road.z_at_xy(p.x(), p.y(), cursor));
  }
};

Built build(const road::Mesh& mesh, const support::TemporaryFolder& folder) {
  road::export_mesh(mesh, folder.path("ring.obj"), {road::UpAxis::z, road::Unit::m});
  road::Recipe recipe = road::recipe_for_mesh(folder.path("ring.obj"));
  recipe.read.up = road::UpAxis::z;
  const auto built = road::make_track(recipe, folder.path("out"));
  return {crg::Surface(crg::read(built.crg_path)),
          base::parse_json<nlohmann::json>(built.summary_json)};
}

/// A road in strips, one of other quads, with cracks of this width between them.
road::Mesh in_strips(double crack_m) {
  road::Mesh mesh;
  add_ring_strip(mesh, "TKMN1", -6.0, -2.0 - crack_m, 0.0, 0.0);
  add_ring_strip(mesh, "TKMN2", -2.0, 2.0, 0.0, 0.0, 0.0, 301.3);
  add_ring_strip(mesh, "TKMN3", -2.0, 2.0, 0.0, 0.0, 301.3 + crack_m, support::kRingLength_m);
  add_ring_strip(mesh, "TKMN4", 2.0 + crack_m, 6.0, 0.0, 0.0, 0.4, support::kRingLength_m + 0.4);
  return mesh;
}

TEST(Cracks, OfAFewCentimetresAreClosedAndCounted) {
  for (const double crack_m : {0.01, 0.03}) {
    const support::TemporaryFolder folder;
    const Built built = build(in_strips(crack_m), folder);
    EXPECT_TRUE(built.summary["validation"]["passed"].get<bool>()) << crack_m;
    EXPECT_EQ(built.summary["sample"]["holes"], 0) << crack_m;
    EXPECT_NEAR(built.summary["reference_line"]["length_m"].get<double>(), support::kRingLength_m,
                0.1);
    for (double s = 0.5; s < 627.0; s += 0.7)
      EXPECT_TRUE(built.has_height(s, 2.0 + 0.5 * crack_m)) << s << ", " << crack_m;
    EXPECT_NE(built.summary["validation"]["remarks"].dump().find("lie over cracks of the mesh"),
              std::string::npos)
        << crack_m;
  }
}

double length_of(const nlohmann::json& ranges) {
  double length_m = 0.0;
  for (const auto& range : ranges)
    length_m += range["u_end_m"].get<double>() - range["u_begin_m"].get<double>();
  return length_m;
}

TEST(Walls, EndTheSurfaceWhereTheyStandInAGapOfTheGround) {
  const support::TemporaryFolder folder;
  road::Mesh mesh = cracked_ring();
  add_ring_strip(mesh, "B0LT1", 6.03, 6.25, 0.8, 0.8, 200.0, 300.0);
  const Built built = build(mesh, folder);
  for (double s = 1.0; s < 627.0; s += 0.5) {
    const bool behind_wall = s > 200.5 && s < 299.5,
               at_its_end = !behind_wall && s > 199.5 && s < 300.5;
    for (const double left : {-8.8, -5.0, 0.0, 5.0, 5.85})
      EXPECT_TRUE(built.has_height(s, left)) << s << ", " << left;
    if (at_its_end) continue;
    for (const double left : {6.1, 6.35, 7.0, 8.8})
      EXPECT_EQ(built.has_height(s, left), !behind_wall) << s << ", " << left;
  }
  EXPECT_NEAR(length_of(built.summary["sample"]["walls"]), 100.0, 1.0);
  EXPECT_EQ(built.summary["sample"]["holes"], 0);
}

TEST(Walls, AreNotWhatHangsOverACrackOrALowEdge) {
  const support::TemporaryFolder folder;
  road::Mesh mesh = cracked_ring();
  add_ring_strip(mesh, "TREE1", 4.0, 9.0, 2.0, 2.0, 150.0, 200.0);     // wider than the crack
  add_ring_strip(mesh, "GANTRY", 6.03, 6.25, 4.0, 4.0, 220.0, 260.0);  // higher than a wall
  add_ring_strip(mesh, "OBJ1", 6.03, 6.25, 0.03, 0.03, 280.0, 320.0);  // lower
  const Built built = build(mesh, folder);
  for (double s = 1.0; s < 627.0; s += 0.5) {
    for (const double left : {5.85, 6.1, 6.35, 8.8})
      EXPECT_TRUE(built.has_height(s, left)) << s << ", " << left;
  }
  EXPECT_TRUE(built.summary["sample"]["walls"].empty());
  EXPECT_GT(built.summary["sample"]["filled"], 3000);
}

TEST(Walls, DoNotEndTheRoadItself) {
  const support::TemporaryFolder folder;
  road::Mesh mesh;
  add_ring_strip(mesh, "TKMN1", -5.0, 2.0, 0.0, 0.0);
  add_ring_strip(mesh, "TKMN2", 2.2, 5.0, 0.0, 0.0, 100.0, 400.0);
  add_ring_strip(mesh, "TKMN3", 2.0, 5.0, 0.0, 0.0, 400.0, support::kRingLength_m + 100.0);
  add_ring_strip(mesh, "B0LT1", 1.99, 2.21, 0.8, 0.8, 200.0, 300.0);
  const Built built = build(mesh, folder);
  for (double s = 1.0; s < 627.0; s += 0.5) EXPECT_TRUE(built.has_height(s, 4.8)) << s;
  EXPECT_TRUE(built.summary["sample"]["walls"].empty());
}

TEST(Cracks, AreClosedBetweenRoadAndRunOffToo) {
  // Run-off that keeps 4 mm away from the road, whose edge at 5 m is a column of the grid: every
  // ray there falls through.
  const support::TemporaryFolder folder;
  road::Mesh mesh;
  add_ring_strip(mesh, "TKMN1", -5.0, 4.998, 0.0, 0.0);
  add_ring_strip(mesh, "TKRS1", -9.0, -5.0, 0.0, 0.0);
  add_ring_strip(mesh, "TKLS1", 5.002, 9.0, 0.01, 0.01, 0.0,
                 300.0);  // 10 mm higher, so that it is not snapped
  add_ring_strip(mesh, "TKLS2", 4.998, 9.0, 0.0, 0.0, 300.0, support::kRingLength_m);
  const Built built = build(mesh, folder);
  for (double s = 1.0; s < 627.0; s += 0.5) {
    for (const double left : {4.95, 5.0, 5.05})
      EXPECT_TRUE(built.has_height(s, left)) << s << ", " << left;
  }
  EXPECT_EQ(built.summary["sample"]["holes"], 0);
  EXPECT_GT(built.summary["sample"]["filled"],
            1500);  // 2349; the chords of the facets close some of the crack
}

TEST(Cracks, AreNoHoles) {
  // The same, 0.35 m wide: wider than what is filled.
  const support::TemporaryFolder folder;
  road::Mesh mesh;
  add_ring_strip(mesh, "TKMN1", -5.0, 4.96, 0.0, 0.0);
  add_ring_strip(mesh, "TKRS1", -9.0, -5.0, 0.0, 0.0);
  add_ring_strip(mesh, "TKLS1", 5.34, 9.0, 0.0, 0.0, 100.0, 300.0);
  add_ring_strip(mesh, "TKLS2", 4.96, 9.0, 0.0, 0.0, 300.0, support::kRingLength_m + 100.0);
  const Built built = build(mesh, folder);
  for (double s = 101.0; s < 299.0; s += 0.5) EXPECT_FALSE(built.has_height(s, 5.15)) << s;
}

}  // namespace gaps_test
