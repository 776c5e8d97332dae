#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "road/clean.h"

namespace corner_holes_test {

using road::CleanReport;
using road::Mesh;
using road::RoadMesh;
using road::SurfaceClass;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr std::size_t kPieces = 120;
// Triangles of a piece of the ring, two each.
constexpr std::size_t kRoad = 0, kOuter = 2, kWall = 4, kInner = 6, kFarOut = 8, kEach = 10;

/// A ring of `radius_m`: road of 12 m, grass of 6 m inside and twice that outside, and a wall 1 m
/// high that stands on the road's inner edge. Vertices are shared.
Mesh ring(double radius_m = 150.0) {
  Mesh mesh;
  mesh.objects = {{"road", "", ""}, {"grass", "", ""}, {"wall", "", ""}};
  const std::vector<Eigen::Vector2d> profile{{-6.0, 0.0}, {6.0, 0.0},   {12.0, 0.0},
                                             {-6.0, 1.0}, {-12.0, 0.0}, {18.0, 0.0}};
  for (std::size_t i = 0; i < kPieces; ++i) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / kPieces;
    for (const Eigen::Vector2d& p : profile)
      mesh.vertices_m.emplace_back((radius_m + p.x()) * std::cos(angle),
                                   (radius_m + p.x()) * std::sin(angle), p.y());
  }
  const auto columns = static_cast<std::uint32_t>(profile.size());
  for (std::uint32_t i = 0; i < kPieces; ++i) {
    const std::uint32_t a = columns * i, b = columns * ((i + 1) % kPieces);
    const auto quad = [&](std::uint32_t inner, std::uint32_t outer, std::uint32_t object) {
      mesh.triangles.push_back({a + inner, a + outer, b + outer});
      mesh.triangles.push_back({a + inner, b + outer, b + inner});
      mesh.object_of_triangle.insert(mesh.object_of_triangle.end(), 2, object);
    };
    quad(0, 1, 0), quad(1, 2, 1), quad(0, 3, 2), quad(4, 0, 1), quad(2, 5, 1);
  }
  return mesh;
}

Mesh without(Mesh mesh, std::vector<std::size_t> triangles) {
  std::sort(triangles.rbegin(), triangles.rend());
  for (const std::size_t t : triangles) {
    mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(t));
    mesh.object_of_triangle.erase(mesh.object_of_triangle.begin() + static_cast<std::ptrdiff_t>(t));
  }
  return mesh;
}

double area_m2(const RoadMesh& road, SurfaceClass surface_class) {
  double sum = 0.0;
  for (std::size_t i = 0; i < road.mesh.triangles.size(); ++i)
    if (road.class_of_triangle[i] == surface_class)
      sum += 0.5 * (road.mesh.vertex(i, 1) - road.mesh.vertex(i, 0))
                       .cross(road.mesh.vertex(i, 2) - road.mesh.vertex(i, 0))
                       .z();
  return sum;
}

/// A regular polygon with kPieces corners: area between two radii.
double ring_area_m2(double inner_m, double outer_m) {
  return 0.5 * kPieces * std::sin(2.0 * std::numbers::pi / kPieces) *
         (outer_m * outer_m - inner_m * inner_m);
}

/// Cleans, and expects all of road and grass with this many holes closed.
void expect_whole(const Mesh& mesh, std::size_t holes) {
  CleanReport report;
  const RoadMesh cleaned = road::clean(mesh, {}, &report);
  EXPECT_EQ(report.holes_closed, holes);
  EXPECT_NEAR(area_m2(cleaned, SurfaceClass::road), ring_area_m2(144, 156), 1e-6);
  EXPECT_NEAR(area_m2(cleaned, SurfaceClass::runoff),
              ring_area_m2(156, 168) + ring_area_m2(138, 144), 1e-6);
  EXPECT_EQ(report.boundary_loops, 2u);
}

TEST(CornerHoles, NothingIsClosedWhereNothingIsMissing) { expect_whole(ring(), 0); }

TEST(CornerHoles, ATriangleIsClosedAndSaid) {
  CleanReport report;
  road::clean(without(ring(), {kRoad + 10 * kEach}), {}, &report);
  EXPECT_NEAR(report.holes_closed_m2, 0.5 * ring_area_m2(144, 156) / kPieces, 2.0);
  EXPECT_THAT(report.remarks, Contains(HasSubstr("a hole of the mesh, between three or four "
                                                 "corners and up to 14.")));
  expect_whole(without(ring(), {kRoad + 10 * kEach}), 1);
  expect_whole(without(ring(), {kOuter + 10 * kEach + 1}), 1);
}

TEST(CornerHoles, TwoBesideEachOtherKeepTheirClasses) {
  expect_whole(without(ring(), {kRoad + 10 * kEach, kRoad + 10 * kEach + 1}), 1);
  // One of road and one of grass that share the edge between them.
  expect_whole(without(ring(), {kRoad + 50 * kEach, kOuter + 50 * kEach + 1}), 1);
}

TEST(CornerHoles, AtTheRimTheThirdEdgeIsThatOfAWall) {
  std::vector<std::size_t> inner_grass;
  for (std::size_t i = 0; i < kPieces; ++i)
    for (const std::size_t k : {0, 1}) inner_grass.push_back(i * kEach + kInner + k);
  std::vector<std::size_t> out = inner_grass;
  out.push_back(70 * kEach + kRoad + 1);
  CleanReport report;
  const RoadMesh cleaned = road::clean(without(ring(), out), {}, &report);
  EXPECT_EQ(report.holes_closed, 1u);
  EXPECT_NEAR(area_m2(cleaned, SurfaceClass::road), ring_area_m2(144, 156), 1e-6);
  // Without the wall's piece nobody knows where the road ended.
  out.insert(out.end(), {70 * kEach + kWall, 70 * kEach + kWall + 1});
  road::clean(without(ring(), out), {}, &report);
  EXPECT_EQ(report.holes_closed, 0u);
}

TEST(CornerHoles, OfTheVergeTheyStay) {
  CleanReport report;
  road::clean(without(ring(), {10 * kEach + kFarOut + 1}), {}, &report);
  EXPECT_EQ(report.holes_closed, 0u);
}

TEST(CornerHoles, LargerOnesStay) {
  CleanReport report;
  // Three triangles in a row: five corners.
  road::clean(without(ring(), {kRoad + 9 * kEach + 1, kRoad + 10 * kEach, kRoad + 10 * kEach + 1}),
              {}, &report);
  EXPECT_EQ(report.holes_closed, 0u);
  // One triangle, 39 m long.
  road::clean(without(ring(750.0), {kRoad + 10 * kEach}), {}, &report);
  EXPECT_EQ(report.holes_closed, 0u);
}

TEST(CornerHoles, AnIslandIsNone) {
  Mesh mesh = without(ring(), {kRoad + 10 * kEach, kRoad + 10 * kEach + 1});
  mesh.objects.push_back({"house", "", ""});
  const auto corner = [&](std::size_t piece, std::size_t column) {
    return static_cast<std::uint32_t>(6 * piece + column);
  };
  const std::vector<std::uint32_t> foot{corner(10, 0), corner(10, 1), corner(11, 1), corner(11, 0)};
  const auto top = static_cast<std::uint32_t>(mesh.vertices_m.size());
  for (const std::uint32_t v : foot)
    mesh.vertices_m.push_back(mesh.vertices_m[v] + Eigen::Vector3d(0.0, 0.0, 4.0));
  for (std::uint32_t k = 0; k < 4; ++k) {
    mesh.triangles.push_back({foot[k], foot[(k + 1) % 4], top + k});
    mesh.object_of_triangle.push_back(3);
  }
  CleanReport report;
  road::clean(mesh, {}, &report);
  EXPECT_EQ(report.holes_closed, 0u);
}

}  // namespace corner_holes_test
