#include "make/missing_piece.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "make/make_track.h"
#include "mesh/export_mesh.h"
#include "support/temporary_folder.h"

namespace missing_piece_test {

using ::testing::HasSubstr;

/// A round line of 100 m radius, 8 m wide, `gap_m` of arc left out, rising by `climb_m` in all.
road::Centreline part_of_a_ring(double gap_m, double climb_m = 0.0) {
  road::Centreline line;
  constexpr int kStations = 300;
  const double angle = 2.0 * std::numbers::pi - gap_m / 100.0;
  for (int i = 0; i <= kStations; ++i) {
    const double t = static_cast<double>(i) / kStations;
    line.points_m.emplace_back(100.0 * std::cos(t * angle), 100.0 * std::sin(t * angle),
                               t * climb_m);
    line.half_width_m.push_back(4.0);
  }
  line.length_m = 100.0 * angle;
  return line;
}

/// The same as a mesh whose objects are called road.
road::Mesh mesh_of(const road::Centreline& line) {
  road::Mesh mesh;
  mesh.objects.push_back({});
  mesh.objects[0].name = "road";
  for (const Eigen::Vector3d& p : line.points_m)
    for (const double v_m : {-4.0, 4.0}) {
      const double r_m = p.head<2>().norm();
      mesh.vertices_m.emplace_back(p.x() * (r_m - v_m) / r_m, p.y() * (r_m - v_m) / r_m, p.z());
    }
  for (std::uint32_t i = 0; i + 1 < line.points_m.size(); ++i) {
    mesh.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 1});
    mesh.triangles.push_back({2 * i + 1, 2 * i + 2, 2 * i + 3});
  }
  mesh.object_of_triangle.assign(mesh.triangles.size(), 0);
  return mesh;
}

TEST(MissingPiece, IsWhereTheEndsFaceEachOther) {
  const auto piece = road::missing_piece(part_of_a_ring(30.0));
  ASSERT_TRUE(piece.has_value());
  EXPECT_NEAR(piece->length_m, 200.0 * std::sin(0.15), 1e-9);  // the chord
  EXPECT_NEAR(piece->middle_m.y(), -100.0 * std::sin(0.15) * std::cos(0.15), 1e-9);
}

TEST(MissingPiece, IsNoneOfAnOpenRoad) {
  EXPECT_FALSE(road::missing_piece(part_of_a_ring(120.0)).has_value()) << "too far apart";
  EXPECT_FALSE(road::missing_piece(part_of_a_ring(30.0, 20.0)).has_value()) << "a ramp, not a ring";
  road::Centreline closed = part_of_a_ring(30.0);
  closed.closed = true;
  EXPECT_FALSE(road::missing_piece(closed).has_value());
  road::Centreline hairpin;  // there and back beside itself: the ends look the same way
  for (int i = 0; i <= 200; ++i) {
    hairpin.points_m.emplace_back(i <= 100 ? 2.0 * i : 2.0 * (200 - i), i <= 100 ? 0.0 : 12.0, 0.0);
    hairpin.half_width_m.push_back(4.0);
  }
  hairpin.length_m = 412.0;
  EXPECT_FALSE(road::missing_piece(hairpin).has_value());
}

TEST(MissingPiece, IsDoubtedAndTheSuggestionLeadsToTheClosedRoad) {
  const support::TemporaryFolder folder;
  road::export_mesh(mesh_of(part_of_a_ring(30.0)), folder.path("ring.obj"));
  road::Recipe recipe = road::recipe_for_mesh(folder.path("ring.obj"));
  recipe.read.up = road::UpAxis::z;
  recipe.read.unit = road::Unit::m;
  recipe.reference_line.u_step_m = recipe.sample.v_step_m = 0.5;
  const road::BuildResult open = road::make_track(recipe, folder.path("open"));
  ASSERT_EQ(open.validation_failures.size(), 1u);
  // A chord of 29.9 m, and rows that are whole from a few centimetres further in on.
  EXPECT_THAT(open.validation_failures[0], HasSubstr("face each other over 30.0 m"));
  EXPECT_THAT(open.validation_failures[0], HasSubstr("--bridge-gap-m 32"));
  recipe.clean.max_gap_m = 32.0;
  const road::BuildResult closed = road::make_track(recipe, folder.path("closed"));
  EXPECT_TRUE(closed.validation_failures.empty()) << closed.validation_failures[0];
  const road::Centreline line = road::read_centreline_csv(closed.centreline_path);
  EXPECT_NEAR(line.length_m, 628.3, 1.0);
}

// Whatever else is thrown while a bridge is tried is a fault, and no sign that none is there.
TEST(MissingPiece, AFaultOfTheTrialIsNoMissingRoad) {
  const road::Centreline line = part_of_a_ring(30.0);
  const road::Mesh mesh = mesh_of(line);
  EXPECT_THAT(road::doubt_about_ends(line, mesh, {}).value_or(""), HasSubstr("--bridge-gap-m 32"));
  road::CleanOptions faulty;
  faulty.name_rules = {{road::NameRule::Field::object, "(road", road::SurfaceClass::road}};
  EXPECT_THROW(road::doubt_about_ends(line, mesh, faulty), road::Error);
}

}  // namespace missing_piece_test
