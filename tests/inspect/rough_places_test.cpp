// Where the file cannot follow the mesh, validation says where and why; and both decks of a figure
// of eight.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "crg/surface.h"
#include "make/make_track.h"
#include "mesh/export_mesh.h"
#include "support/analytic_roads.h"
#include "support/figure.h"
#include "support/mutate_mesh.h"
#include "support/ring_strips.h"
#include "support/temporary_folder.h"

namespace rough_places_test {

/// A ring of 100 m radius with one vertex row every metre at each of v_m; z of (angle, v).
road::Mesh ring(const std::vector<double>& v_m,
                const std::function<double(double u_m, double v_m)>& z) {
  road::Mesh mesh;
  constexpr std::uint32_t kStations = 628;
  mesh.objects.push_back({});
  mesh.objects[0].name = "road";
  const auto columns = static_cast<std::uint32_t>(v_m.size());
  for (std::uint32_t i = 0; i < kStations; ++i) {
    const double angle = 2.0 * M_PI * i / kStations;
    for (const double v : v_m)
      mesh.vertices_m.emplace_back((100.0 - v) * std::cos(angle), (100.0 - v) * std::sin(angle),
                                   z(100.0 * angle, v));
  }
  for (std::uint32_t i = 0; i < kStations; ++i) {
    const std::uint32_t a = i * columns, b = (i + 1) % kStations * columns;
    for (std::uint32_t j = 0; j + 1 < columns; ++j) {
      mesh.triangles.push_back({a + j, b + j, a + j + 1});
      mesh.triangles.push_back({b + j, b + j + 1, a + j + 1});
      mesh.object_of_triangle.insert(mesh.object_of_triangle.end(), 2, 0);
    }
  }
  return mesh;
}

nlohmann::json build(const road::Mesh& mesh, const support::TemporaryFolder& folder,
                     const std::string& ending, std::string* crg_path = nullptr) {
  const std::string file = folder.path("mesh." + ending);
  road::export_mesh(mesh, file, {road::UpAxis::z, road::Unit::m});
  road::Recipe recipe = road::recipe_for_mesh(file);
  recipe.read.up = road::UpAxis::z;
  recipe.kerb.max_extra_columns_share = 0.0;  // a grid as coarse as it comes
  const auto built = road::make_track(recipe, folder.path("out_" + ending));
  if (crg_path != nullptr) *crg_path = built.crg_path;
  return base::parse_json<nlohmann::json>(built.summary_json);
}

TEST(RoughPlaces, ASmoothRoadHasNone) {
  const support::TemporaryFolder folder;
  EXPECT_TRUE(build(ring({-5, 0, 5}, [](double, double v) { return 0.03 * v; }), folder,
                    "obj")["validation"]["rough_places"]
                  .empty());
}

TEST(RoughPlaces, AStepNarrowerThanACellIsNamedWithItsRange) {
  // 80 mm up within 4 mm, over a third of the ring: a ramp of a whole cell in the grid.
  const support::TemporaryFolder folder;
  const auto summary = build(
      ring({-5, 0, 3.03, 3.034, 5},
           [](double u, double v) { return u > 200.0 && u < 400.0 && v > 3.032 ? 0.08 : 0.0; }),
      folder, "obj");
  const auto& places = summary["validation"]["rough_places"];
  ASSERT_FALSE(places.empty());
  double covered_m = 0.0, largest_m = 0.0;
  for (const auto& place : places) {
    covered_m += place["u_end_m"].get<double>() - place["u_begin_m"].get<double>();
    largest_m = std::max(largest_m, place["largest_error_m"].get<double>());
    EXPECT_THAT(place["reason"].get<std::string>(), testing::HasSubstr("steps or folds between"));
    EXPECT_NEAR(std::abs(place["v_min_m"].get<double>()), 3.03, 0.15);
    EXPECT_NEAR(std::abs(place["v_max_m"].get<double>()), 3.03, 0.15);
  }
  EXPECT_NEAR(covered_m, 200.0, 3.0);
  EXPECT_GT(largest_m, 0.015);
  EXPECT_LE(largest_m, 0.08);
}

/// Every stretch of `places` with this reason; the others are counted.
nlohmann::json with_reason(const nlohmann::json& places, const std::string& reason) {
  auto some = nlohmann::json::array();
  for (const auto& place : places) {
    if (place["reason"].get<std::string>().find(reason) != std::string::npos) some.push_back(place);
  }
  return some;
}

TEST(RoughPlaces, TwoSurfacesAreNamedWhereTheFileChangesFromOneToTheOther) {
  // A plate that grows out of the road to the left until it is 60 mm above it, and ends: the file
  // drops within a cell.
  const support::TemporaryFolder folder;
  road::Mesh mesh;
  support::add_ring_strip(mesh, "TKMN1", -5.0, 1.0, 0.0, 0.0);
  support::add_ring_strip(mesh, "TKMN2", 1.0, 5.0, 0.0, 0.0);
  support::add_ring_strip(mesh, "TKMN3", 1.0, 3.04, 0.0, 0.06);
  const auto all = build(mesh, folder, "obj")["validation"]["rough_places"];
  const auto places = with_reason(all, "two surfaces");
  ASSERT_FALSE(places.empty());
  double covered_m = 0.0;
  for (const auto& place : places) {
    EXPECT_GT(place["largest_error_m"], 0.015);
    EXPECT_LE(place["largest_error_m"],
              0.0361);  // beside the plate's edge the ramp from v = 3.0 to 3.1 m still has 36 mm
    covered_m += place["u_end_m"].get<double>() - place["u_begin_m"].get<double>();
  }
  EXPECT_NEAR(covered_m, support::kRingLength_m, 5.0);
  EXPECT_EQ(places.size(), all.size());
}

TEST(RoughPlaces, NodesOffTheMeshAreNamedWhereAGapWasFilledUnderSomething) {
  // The road has a gap of 0.2 m, and all that the mesh has there is a beam half a metre above: the
  // nodes are even, the file is smooth, and only a look at the mesh tells.
  const support::TemporaryFolder folder;
  road::Mesh mesh;
  support::add_ring_strip(mesh, "TKMN1", -5.0, 2.0, 0.0, 0.0);
  support::add_ring_strip(mesh, "TKMN2", 2.2, 5.0, 0.0, 0.0, 100.0, 400.0);
  support::add_ring_strip(mesh, "TKMN3", 2.0, 5.0, 0.0, 0.0, 400.0, support::kRingLength_m + 100.0);
  support::add_ring_strip(mesh, "B0LT1", 2.0, 2.2, 0.5, 0.5, 200.0, 300.0);
  const auto all = build(mesh, folder, "obj")["validation"]["rough_places"];
  const auto places = with_reason(all, "own nodes are off the mesh");
  ASSERT_FALSE(places.empty());
  double covered_m = 0.0;
  for (const auto& place : all) {
    EXPECT_NEAR(std::abs(place["v_min_m"].get<double>()), 2.1, 0.15);
    EXPECT_NEAR(std::abs(place["v_max_m"].get<double>()), 2.1, 0.15);
    EXPECT_NEAR(place["largest_error_m"].get<double>(), 0.5, 1e-3);
    covered_m += place["u_end_m"].get<double>() - place["u_begin_m"].get<double>();
  }
  EXPECT_NEAR(covered_m, 100.0, 3.0);
}

TEST(RoughPlaces, SmoothingBeyondItsBoundIsNamed) {
  // Bumps of 30 mm every 6 m, and a window of 6 m that may move the road by 40 mm.
  const support::TemporaryFolder folder;
  const road::Mesh mesh = ring({-5, 0, 5}, [](double u, double) {
    return u > 200.0 && u < 300.0 ? 0.03 * std::sin(2.0 * M_PI * u / 6.0) : 0.0;
  });
  const std::string file = folder.path("mesh.obj");
  road::export_mesh(mesh, file, {road::UpAxis::z, road::Unit::m});
  road::Recipe recipe = road::recipe_for_mesh(file);
  recipe.read.up = road::UpAxis::z;
  recipe.smooth.window_u_m = 6.0;
  recipe.smooth.max_change_road_m = 0.04;
  const auto summary =
      base::parse_json<nlohmann::json>(road::make_track(recipe, folder.path("out")).summary_json);
  const auto& all = summary["validation"]["rough_places"];
  ASSERT_FALSE(all.empty());
  EXPECT_EQ(with_reason(all, "own nodes are off the mesh").size(), all.size());
  double largest_m = 0.0;
  for (const auto& place : all)
    largest_m = std::max(largest_m, place["largest_error_m"].get<double>());
  EXPECT_NEAR(largest_m, 0.03, 0.006);  // the chords of the mesh, 1 m long, cut up to 4 mm off the
                                        // bumps; a window of one wave leaves nothing
}

TEST(RoughPlaces, BothDecksOfAFigureOfEightAreRight) {
  const support::AnalyticRoad eight = support::figure_eight();
  road::Mesh damaged = support::delete_triangles(support::jitter(eight.mesh, 1e-3, 7), 0.005, 8);
  for (const auto& [mesh, what] : {std::pair{eight.mesh, "whole"}, {damaged, "damaged"}}) {
    for (const std::string ending : {"obj", "stl"}) {
      if (std::getenv("KERBSTONE_HEAVY") == nullptr &&
          (ending == "obj") != (what == std::string("whole")))
        continue;
      const support::TemporaryFolder folder;
      std::string path;
      build(mesh, folder, ending, &path);
      const crg::Surface road(crg::read(path));
      const crg::ReferenceLine& line = road.reference_line();
      const crg::Grid& grid = road.grid();
      std::size_t nodes = 0, wrong = 0;
      for (std::size_t i = 0; i + 1 < line.size(); i += 5) {
        // The place of the design: near, and going the same way or the opposite one (the legs cross
        // at right angles).
        double best = 1e9, u = 0.0;
        for (double at = 0.0; at < eight.length_m; at += 1.0) {
          const crg::Point2 a = eight.position_m(at, 0.0), b = eight.position_m(at + 0.1, 0.0);
          const double along = std::cos(line.heading_rad[i]) * (b.x_m - a.x_m) +
                               std::sin(line.heading_rad[i]) * (b.y_m - a.y_m);
          if (std::abs(along) < 0.8 * std::hypot(b.x_m - a.x_m, b.y_m - a.y_m)) continue;
          const double distance = std::hypot(a.x_m - line.x_m[i], a.y_m - line.y_m[i]);
          if (distance < best) best = distance, u = at;
        }
        for (std::size_t j = 0; j < grid.columns(); ++j) {
          const double z = road.z_at_uv(grid.u_of(i), grid.v_m[j]);
          if (std::isnan(z)) continue;
          ++nodes;
          wrong += std::abs(z - eight.z_m(u, 0.0)) > 0.5
                       ? 1
                       : 0;  // the road climbs 4 % at most: decks are 8.8 m apart
        }
      }
      support::figure_of_case("wrong", static_cast<double>(wrong));
      support::figure_of_case("nodes", static_cast<double>(nodes));
      EXPECT_GT(nodes, 150000u);
      EXPECT_EQ(wrong, 0u) << what << " ." << ending;
    }
  }
}

}  // namespace rough_places_test
