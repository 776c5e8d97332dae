// Where the file cannot follow the mesh, validation says where and why; and both decks of a figure of eight.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>

#include "crg/surface.h"
#include "road/build.h"
#include "road/export_mesh.h"
#include "support/analytic_roads.h"
#include "support/mutate_mesh.h"
#include "support/temporary_folder.h"

namespace {

/// A ring of 100 m radius with one vertex row every metre at each of v_m; z of (angle, v).
road::Mesh ring(const std::vector<double>& v_m, const std::function<double(double u_m, double v_m)>& z) {
  road::Mesh mesh;
  constexpr std::uint32_t kStations = 628;
  mesh.objects.push_back({});
  mesh.objects[0].name = "road";
  const auto columns = static_cast<std::uint32_t>(v_m.size());
  for (std::uint32_t i = 0; i < kStations; ++i) {
    const double angle = 2.0 * M_PI * i / kStations;
    for (const double v : v_m) mesh.vertices_m.emplace_back((100.0 - v) * std::cos(angle), (100.0 - v) * std::sin(angle), z(100.0 * angle, v));
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

nlohmann::json build(const road::Mesh& mesh, const support::TemporaryFolder& folder, const std::string& ending, std::string* crg_path = nullptr) {
  const std::string file = folder.path("mesh." + ending);
  road::export_mesh(mesh, file, {road::UpAxis::z, road::Unit::m});
  road::Recipe recipe = road::recipe_for_mesh(file);
  recipe.read.up = road::UpAxis::z;
  recipe.kerb.max_extra_columns_share = 0.0;  // a grid as coarse as it comes
  const auto built = road::build_track(recipe, folder.path("out_" + ending));
  if (crg_path != nullptr) *crg_path = built.crg_path;
  return nlohmann::json::parse(built.summary_json);
}

TEST(RoughPlaces, ASmoothRoadHasNone) {
  const support::TemporaryFolder folder;
  EXPECT_TRUE(build(ring({-5, 0, 5}, [](double, double v) { return 0.03 * v; }), folder, "obj")["validation"]["rough_places"].empty());
}

TEST(RoughPlaces, AStepNarrowerThanACellIsNamedWithItsRange) {
  // 80 mm up within 4 mm, over a third of the ring: a ramp of a whole cell in the grid.
  const support::TemporaryFolder folder;
  const auto summary = build(ring({-5, 0, 3.03, 3.034, 5}, [](double u, double v) { return u > 200.0 && u < 400.0 && v > 3.032 ? 0.08 : 0.0; }), folder, "obj");
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

TEST(RoughPlaces, BothDecksOfAFigureOfEightAreRight) {
  const support::AnalyticRoad eight = support::figure_eight();
  road::Mesh damaged = support::delete_triangles(support::jitter(eight.mesh, 1e-3, 7), 0.005, 8);
  for (const auto& [mesh, what] : {std::pair{eight.mesh, "whole"}, {damaged, "damaged"}}) {
    for (const char* ending : {"obj", "stl"}) {
      const support::TemporaryFolder folder;
      std::string path;
      build(mesh, folder, ending, &path);
      const crg::Surface road(crg::read(path));
      const crg::ReferenceLine& line = road.reference_line();
      const crg::Grid& grid = road.file().grid;
      std::size_t nodes = 0, wrong = 0;
      for (std::size_t i = 0; i + 1 < line.size(); i += 5) {
        // The place of the design: near, and going the same way or the opposite one (the legs cross at right angles).
        double best = 1e9, u = 0.0;
        for (double at = 0.0; at < eight.length_m; at += 1.0) {
          const crg::Point2 a = eight.position_m(at, 0.0), b = eight.position_m(at + 0.1, 0.0);
          const double along = std::cos(line.heading_rad[i]) * (b.x_m - a.x_m) + std::sin(line.heading_rad[i]) * (b.y_m - a.y_m);
          if (std::abs(along) < 0.8 * std::hypot(b.x_m - a.x_m, b.y_m - a.y_m)) continue;
          const double distance = std::hypot(a.x_m - line.x_m[i], a.y_m - line.y_m[i]);
          if (distance < best) best = distance, u = at;
        }
        for (std::size_t j = 0; j < grid.columns(); ++j) {
          const double z = road.z_at_uv(grid.u_of(i), grid.v_m[j]);
          if (std::isnan(z)) continue;
          ++nodes;
          wrong += std::abs(z - eight.z_m(u, 0.0)) > 0.5 ? 1 : 0;  // the road climbs 4 % at most: decks are 8.8 m apart
        }
      }
      std::printf("figure of eight, %s, .%s: %zu of %zu nodes on the wrong deck\n", what, ending, wrong, nodes);
      EXPECT_GT(nodes, 150000u);
      EXPECT_EQ(wrong, 0u) << what << " ." << ending;
    }
  }
}

}  // namespace
