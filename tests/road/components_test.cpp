#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "mesh_topology.h"
#include "road/clean.h"

namespace components_test {

using road::CleanOptions;
using road::CleanReport;
using road::Components;
using road::Mesh;
using road::Triangle;

using Numbers = std::vector<std::uint32_t>;

TEST(Components, AreNumberedInOrderOfTheirFirstTriangle) {
  // Two squares without a shared vertex, their triangles in turns.
  const Components found = road::components({{4, 5, 6}, {0, 1, 2}, {4, 6, 7}, {0, 2, 3}});
  EXPECT_EQ(found.of_triangle, (Numbers{0, 1, 0, 1}));
  EXPECT_EQ(found.count, 2u);
  EXPECT_TRUE(found.at_non_manifold_edges.empty());
  EXPECT_EQ(road::components({}).count, 0u);
}

TEST(Components, FacesThatPointTheOtherWayBelongToTheSheet) {
  // A fan around vertex 0; every other face is turned.
  const Components found =
      road::components({{0, 1, 2}, {0, 3, 2}, {0, 3, 4}, {0, 5, 4}, {0, 5, 6}});
  EXPECT_EQ(found.of_triangle, (Numbers{0, 0, 0, 0, 0}));
  EXPECT_TRUE(found.at_non_manifold_edges.empty());
}

TEST(Components, SheetsThatMeetInAVertexAloneAreTwo) {
  EXPECT_EQ(road::components({{0, 1, 2}, {0, 3, 4}}).of_triangle, (Numbers{0, 1}));
}

TEST(Components, SheetsThatMeetInAnEdgeAreOneAndTheEdgeIsNamed) {
  // Three sheets of two triangles each at the edge 0-1, as a wall on a road; a square beside them.
  const Components found = road::components(
      {{9, 10, 11}, {0, 1, 2}, {1, 3, 2}, {1, 0, 4}, {0, 5, 4}, {0, 1, 6}, {1, 7, 6}, {9, 11, 12}});
  EXPECT_EQ(found.of_triangle, (Numbers{0, 1, 1, 1, 1, 1, 1, 0}));
  EXPECT_EQ(found.count, 2u);
  EXPECT_EQ(found.at_non_manifold_edges, (Numbers{1}));
}

TEST(Components, AStripWithOneSideIsOneSheet) {
  // Five triangles, each of which shares two of its edges with its neighbours: a Moebius strip.
  const Components found =
      road::components({{0, 1, 2}, {1, 2, 3}, {2, 3, 4}, {3, 4, 0}, {4, 0, 1}});
  EXPECT_EQ(found.of_triangle, (Numbers{0, 0, 0, 0, 0}));
  EXPECT_TRUE(found.at_non_manifold_edges.empty());
}

void add(Mesh& mesh, std::uint32_t object, const std::vector<Eigen::Vector3d>& corners) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
  mesh.vertices_m.insert(mesh.vertices_m.end(), corners.begin(), corners.end());
  for (std::uint32_t k = 2; k < corners.size(); ++k) {
    mesh.triangles.push_back({first, first + k - 1, first + k});
    mesh.object_of_triangle.push_back(object);
  }
}

/// A road of 40 m x 8 m along x, four squares of 10 m, none of which share vertices.
Mesh straight_road() {
  Mesh mesh;
  mesh.objects = {{"road", "", ""}, {"kerb", "", ""}};
  for (int i = 0; i < 4; ++i) {
    const double x = 10.0 * i;
    add(mesh, 0, {{x, 0, 0}, {x + 10, 0, 0}, {x + 10, 8, 0}, {x, 8, 0}});
  }
  return mesh;
}

CleanReport report_of(const Mesh& mesh) {
  CleanOptions options;
  options.use_names = road::UseNames::yes;
  CleanReport report;
  road::clean(mesh, options, &report);
  return report;
}

TEST(Components, OfASoupWithFaultsAreThoseOfTheRoad) {
  CleanReport report = report_of(straight_road());
  EXPECT_EQ(report.triangles_kept, 8u);
  EXPECT_EQ(report.vertices_welded, 6u);  // 16 corners on 10 places
  EXPECT_EQ(report.components, 1u);
  EXPECT_EQ(report.non_manifold_edges, 0u);

  Mesh mesh = straight_road();
  std::swap(mesh.triangles[2][0], mesh.triangles[2][1]);  // points down
  // The second square once more, and its first half a third time, pointing down.
  add(mesh, 0, {{10, 0, 0}, {20, 0, 0}, {20, 8, 0}, {10, 8, 0}});
  add(mesh, 0, {{10, 0, 0}, {20, 8, 0}, {20, 0, 0}});
  // Goes on in two squares, between whose corners the road's end has none: a T-junction. They touch
  // the road there, and share no edge with it.
  add(mesh, 0, {{40, 0, 0}, {50, 0, 0}, {50, 4, 0}, {40, 4, 0}});
  add(mesh, 0, {{40, 4, 0}, {50, 4, 0}, {50, 8, 0}, {40, 8, 0}});
  // A kerb's face on the line across the road at x = 10 m: there three triangles meet.
  add(mesh, 1, {{10, 0, 0}, {10, 8, 0}, {10, 4, 0.1}});
  // Passes through the road at a slope, and shares no vertex with it; so does its other face.
  add(mesh, 0, {{22, 2, -1}, {28, 2, 1}, {28, 6, 1}, {22, 6, -1}});
  // Three sheets at one edge, far away: none of the road, and so is its edge.
  add(mesh, 0, {{100, 0, 0}, {102, 0, 0}, {102, 2, 0}});
  add(mesh, 0, {{100, 0, 0}, {102, 0, 0}, {102, 2, 0.5}});
  add(mesh, 0, {{102, 0, 0}, {100, 0, 0}, {100, -2, 0}});
  report = report_of(mesh);
  EXPECT_EQ(report.dropped["duplicate"], 3u);
  // Two of the road and the two joined squares; the sheet through it; the three far away.
  EXPECT_EQ(report.components, 4u);
  EXPECT_EQ(report.dropped["not connected"], 2u + 3u);
  EXPECT_EQ(report.triangles_kept, 8u + 4u + 1u);
  EXPECT_EQ(report.non_manifold_edges, 1u);
}

}  // namespace components_test
