// Of surfaces that lie over each other in one mesh the one is taken that a wheel meets; marks that
// stick out of the road are cut.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "road/centreline.h"
#include "road/clean.h"
#include "support/ring_strips.h"

namespace clean_layers_test {

using support::add_ring_strip;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

/// Heights of the corners of what is kept.
std::pair<double, double> heights_of(const road::RoadMesh& kept) {
  double low_m = 1e9, high_m = -1e9;
  for (std::size_t t = 0; t < kept.mesh.triangles.size(); ++t)
    for (int c = 0; c < 3; ++c) {
      const double z_m = kept.mesh.origin_m.z() + kept.mesh.vertex(t, c).z();
      low_m = std::min(low_m, z_m), high_m = std::max(high_m, z_m);
    }
  return {low_m, high_m};
}

TEST(Layers, TheFinestLevelOfDetailIsTaken) {
  for (const char* coarse : {"road_LOD1", "road_LOD2", "road_lod_3"}) {
    road::Mesh mesh;
    add_ring_strip(mesh, "road_LOD0", -5.0, 5.0, 0.0, 0.0);
    add_ring_strip(mesh, coarse, -5.0, 5.0, 0.03, 0.03);
    road::CleanReport report;
    const auto [low_m, high_m] = heights_of(road::clean(mesh, {}, &report));
    EXPECT_EQ(low_m, 0.0);
    EXPECT_EQ(high_m, 0.0) << coarse;
  }
}

TEST(Layers, OfTwoSuperposedSurfacesTheFinerIsTaken) {
  // 0: 4, all in one object without a name; 1: the same, and corners that are the finer one's.
  for (const std::size_t coarse_step : {2, 4, 0, 1}) {
    road::Mesh mesh;
    const double over_m = coarse_step == 1 ? 0.0 : 0.01;
    add_ring_strip(mesh, "road", -5.0, 5.0, 0.0, 0.0);
    const std::size_t fine = mesh.triangles.size();
    add_ring_strip(mesh, "road far", -5.0, 5.0, over_m, over_m);
    // Quads of so many metres in place of those of 1 m.
    const std::size_t step = coarse_step > 1 ? coarse_step : 4;
    const std::size_t quads = (mesh.triangles.size() - fine) / 2;
    std::vector<std::array<std::uint32_t, 3>> coarse;
    for (std::size_t i = 0; i < quads; i += step) {
      const std::size_t last = std::min(i + step, quads) - 1;
      const auto a = mesh.triangles[fine + 2 * i];
      const auto b = mesh.triangles[fine + 2 * last + 1];
      coarse.push_back({a[0], b[0], a[2]});
      coarse.push_back({b[0], b[1], a[2]});
    }
    mesh.triangles.resize(fine);
    mesh.triangles.insert(mesh.triangles.end(), coarse.begin(), coarse.end());
    mesh.object_of_triangle.resize(mesh.triangles.size());
    if (coarse_step < 2) {
      mesh.objects.assign(1, {});
      std::fill(mesh.object_of_triangle.begin(), mesh.object_of_triangle.end(), 0);
    }
    if (coarse_step == 1)
      for (Eigen::Vector3d& v : mesh.vertices_m)
        v.z() = 0.5 * std::sin(20.0 * std::atan2(v.y(), v.x()));
    road::CleanReport report;
    const auto heights_m = heights_of(road::clean(mesh, {}, &report));
    if (coarse_step != 1) EXPECT_EQ(heights_m, std::pair(0.0, 0.0)) << coarse_step;
    if (coarse_step == 1)  // some lie in the finer ones' planes
      EXPECT_GT(report.left_out.size(), 9 * coarse.size() / 10);
    else
      EXPECT_EQ(report.left_out.size(), coarse.size()) << coarse_step;
  }
}

TEST(Layers, WordsThatHoldLodAreNoLevels) {
  road::Mesh mesh;
  add_ring_strip(mesh, "road melod1", -5.0, 0.0, 0.0, 0.0);
  add_ring_strip(mesh, "road melod0", 0.0, 5.0, 0.0, 0.0);
  EXPECT_EQ(road::clean(mesh).mesh.triangles.size(), mesh.triangles.size());
}

TEST(Layers, AnUndersideIsLeftOut) {
  road::Mesh mesh;
  add_ring_strip(mesh, "", -5.0, 5.0, 1.0, 1.0);
  const std::size_t upper = mesh.triangles.size();
  add_ring_strip(mesh, "", -5.0, 5.0, 0.67, 0.67);
  for (std::size_t t = upper; t < mesh.triangles.size(); ++t) {
    std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    mesh.object_of_triangle[t] = 0;
  }
  road::CleanReport report;
  const auto [low_m, high_m] = heights_of(road::clean(mesh, {}, &report));
  EXPECT_EQ(low_m, 1.0);
  EXPECT_EQ(high_m, 1.0);
  EXPECT_THAT(report.remarks, Contains(HasSubstr("that look up, left out")));
}

TEST(Layers, AnUndersideThatIsAnObjectOfItsOwnIsLeftOut) {
  for (const char* material : {"asphalt", "concrete"}) {
    road::Mesh mesh;
    add_ring_strip(mesh, "road", -5.0, 5.0, 1.0, 1.0);
    const std::size_t upper = mesh.triangles.size();
    add_ring_strip(mesh, "road_bottom", -5.0, 5.0, 0.67, 0.67);
    for (std::size_t t = upper; t < mesh.triangles.size(); ++t)
      std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    mesh.objects[0].material = "asphalt";
    mesh.objects[1].material = material;
    road::CleanReport report;
    EXPECT_EQ(heights_of(road::clean(mesh, {}, &report)), std::pair(1.0, 1.0));
    const bool is_alike = mesh.objects[0].material == material;
    EXPECT_EQ(report.remarks.size(), is_alike ? 1u : 0u) << material;
  }
}

/// A ring of 10 m on walls of 30 m, closed below.
road::Mesh thick_body() {
  road::Mesh mesh;
  add_ring_strip(mesh, "", -5.0, 5.0, 20.0, 20.0);
  add_ring_strip(mesh, "", 5.0, 5.0, 20.0, -10.0);
  add_ring_strip(mesh, "", 5.0, -5.0, -10.0, -10.0);
  add_ring_strip(mesh, "", -5.0, -5.0, -10.0, 20.0);
  std::fill(mesh.object_of_triangle.begin(), mesh.object_of_triangle.end(), 0);
  return mesh;
}

TEST(Layers, AThickBodyHasAnUnderside) {
  const auto [low_m, high_m] = heights_of(road::clean(thick_body()));
  EXPECT_EQ(low_m, 20.0);
  EXPECT_EQ(high_m, 20.0);
}

TEST(Layers, UnderADeckWithoutSidesOneDrives) {
  road::Mesh mesh = thick_body();
  const std::size_t strip = mesh.triangles.size() / 4;
  mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(strip),
                       mesh.triangles.begin() + static_cast<std::ptrdiff_t>(2 * strip));
  mesh.object_of_triangle.resize(mesh.triangles.size());
  road::CleanReport report;
  road::clean(mesh, {}, &report);
  EXPECT_THAT(report.remarks, Not(Contains(HasSubstr("left out"))));
}

TEST(Layers, WhatLooksDownWithoutAnUpperSideIsRoad) {
  road::Mesh mesh;
  add_ring_strip(mesh, "", -5.0, 5.0, 0.0, 0.0);
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 2)
    std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  EXPECT_EQ(road::clean(mesh).mesh.triangles.size(), mesh.triangles.size());
}

/// A road of 10 m with a gap of 3 m that a stroke of 30 m across fills, under the same name.
road::Mesh road_with_a_stroke() {
  road::Mesh mesh;
  add_ring_strip(mesh, "track", -5.0, 5.0, 0.0, 0.0, 3.0);
  mesh.objects.back().material = "Road";
  for (const auto& [right_m, left_m] : {std::pair(-15.0, -5.0), {-5.0, 5.0}, {5.0, 15.0}}) {
    add_ring_strip(mesh, "track", right_m, left_m, 0.0, 0.0, 0.0, 3.0);
    mesh.objects.back().material = "Circles";
  }
  // One object for each material, as files have them.
  for (std::uint32_t& object : mesh.object_of_triangle) object = object == 0 ? 0 : 1;
  return mesh;
}

TEST(Layers, AStrokeAcrossAGapIsCutAtTheEdges) {
  road::CleanReport report;
  const road::RoadMesh kept = road::clean(road_with_a_stroke(), {}, &report);
  EXPECT_THAT(report.remarks, Contains(HasSubstr("object 'track' (material 'Circles')")));
  const road::Centreline line = road::trace_centreline(kept);
  EXPECT_TRUE(line.closed);
  EXPECT_NEAR(line.length_m, support::kRingLength_m, 0.1);
  EXPECT_NEAR(*std::max_element(line.half_width_m.begin(), line.half_width_m.end()), 5.0, 0.05);
}

TEST(Layers, TwoLegsSideBySideAreNotOneRoad) {
  // A long loop whose two straights lie 1.7 m apart: 9 m wide each, in quads of 5 m.
  road::Mesh mesh;
  mesh.objects = {{"road", "", ""}};
  const double straight_m = 300.0, apart_m = 10.7, turn_m = 20.0;
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> rows;  // middle, left
  const auto add = [&](double x, double y, double heading) {
    rows.push_back({{x, y}, {-std::sin(heading), std::cos(heading)}});
  };
  for (double s = 0.0; s < straight_m; s += 5.0) add(s, 0.0, 0.0);
  // Out and round: a bulb of 270 + 2 * 45 degrees at each end.
  const auto bulb = [&](double x0, double y0, double heading0) {
    double x = x0, y = y0, heading = heading0;
    const auto turn = [&](double angle, double radius_m) {
      const int steps = static_cast<int>(std::ceil(std::abs(angle) * radius_m / 2.0));
      for (int k = 0; k < steps; ++k) {
        const double d = angle / steps;
        x += radius_m * std::abs(d) * std::cos(heading + 0.5 * d);
        y += radius_m * std::abs(d) * std::sin(heading + 0.5 * d);
        heading += d;
        add(x, y, heading);
      }
    };
    // Away from the other leg, a wide turn back: the lateral offsets add up to apart_m.
    const double away = std::acos(1.0 - (2.0 * turn_m - apart_m) / (4.0 * turn_m));
    turn(-away, turn_m);
    turn(M_PI + 2.0 * away, turn_m);
    turn(-away, turn_m);
  };
  bulb(rows.back().first.x(), 0.0, 0.0);
  const double back_x = rows.back().first.x(), back_y = rows.back().first.y();
  for (double s = 5.0; s < straight_m; s += 5.0) add(back_x - s, back_y, M_PI);
  bulb(rows.back().first.x(), back_y, M_PI);
  rows.pop_back();  // the first again
  const std::size_t n = rows.size();
  for (const auto& [middle, left] : rows)
    for (const double side : {-4.5, 4.5}) {
      const Eigen::Vector2d p = middle + side * left;
      mesh.vertices_m.emplace_back(p.x(), p.y(), 0.0);
    }
  for (std::uint32_t i = 0; i < n; ++i) {
    const auto a = 2 * i, b = static_cast<std::uint32_t>(2 * ((i + 1) % n));
    mesh.triangles.push_back({a, b, a + 1});
    mesh.triangles.push_back({b, b + 1, a + 1});
    mesh.object_of_triangle.insert(mesh.object_of_triangle.end(), 2, 0u);
  }
  double length_m = 0.0;
  for (std::size_t i = 0; i < n; ++i) length_m += (rows[(i + 1) % n].first - rows[i].first).norm();
  const road::Centreline line = road::trace_centreline(road::clean(mesh));
  EXPECT_TRUE(line.closed);
  EXPECT_NEAR(line.length_m, length_m, 0.01 * length_m);
  EXPECT_LT(*std::max_element(line.half_width_m.begin(), line.half_width_m.end()), 5.5);
}

}  // namespace clean_layers_test
