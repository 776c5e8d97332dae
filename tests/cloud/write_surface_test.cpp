#include "cloud/write_surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "cloud/error.h"
#include "cloud/read_cloud.h"
#include "mesh/read_mesh.h"
#include "support/temporary_folder.h"

namespace cloud {
namespace write_surface_test {

constexpr double kGrade = 0.06, kSlope = 0.03;

/// A tilted plane along x, far from zero, 40 x 6 m; one node is a hole.
crg::Crg tilted() {
  crg::ReferenceLine line;
  line.u_step_m = 0.5;
  crg::Grid grid;
  grid.u_step_m = line.u_step_m;
  for (int j = -6; j <= 6; ++j) grid.v_m.push_back(0.5 * j);
  for (int i = 0; i <= 80; ++i) {
    line.x_m.push_back(485000.0 + 0.5 * i), line.y_m.push_back(5429000.0);
    line.heading_rad.push_back(0.0);
    for (const double v : grid.v_m)
      grid.z_m.push_back(static_cast<float>(112.0 + kGrade * 0.5 * i + kSlope * v));
  }
  grid.z_m[20 * 13 + 5] = std::numeric_limits<float>::quiet_NaN();
  return crg::make_crg(line, grid);
}

crg::Grid deviations(const crg::Crg& road) {
  crg::Grid stddev = road.grid;
  for (std::size_t k = 0; k < stddev.z_m.size(); ++k)
    stddev.z_m[k] = 0.001f * static_cast<float>(k % 7);
  return stddev;
}

TEST(WriteSurface, NormalsAreThoseOfThePlaneAndPlacesThoseOfTheNodes) {
  const crg::Crg road = tilted();
  const NodeSurface surface = node_surface(road, deviations(road));
  ASSERT_EQ(surface.place_m.size(), 81u * 13u - 1u);
  // Two triangles a cell, less the six around the hole.
  EXPECT_EQ(surface.triangles.size(), 2u * 80u * 12u - 6u);
  const Eigen::Vector3d normal = Eigen::Vector3d(-kGrade, -kSlope, 1.0).normalized();
  for (std::size_t k = 0; k < surface.place_m.size(); ++k) {
    const Eigen::Vector3d p = surface.origin_m + surface.place_m[k];
    EXPECT_NEAR(p.z(), 112.0 + kGrade * (p.x() - 485000.0) + kSlope * (p.y() - 5429000.0), 1e-5);
    EXPECT_LT((surface.normal[k].cast<double>() - normal).norm(), 1e-4);
  }
  for (const auto& t : surface.triangles) {
    const Eigen::Vector3d a = surface.place_m[t[1]] - surface.place_m[t[0]],
                          b = surface.place_m[t[2]] - surface.place_m[t[0]];
    EXPECT_GT(a.x() * b.y() - a.y() * b.x(), 0.0);
  }
}

TEST(WriteSurface, RowsAreLeftOutAndTheLastStays) {
  const crg::Crg road = tilted();
  const NodeSurface surface = node_surface(road, deviations(road), 300);
  EXPECT_LE(surface.place_m.size(), 300u);
  EXPECT_NEAR(surface.origin_m.x() + surface.place_m.back().x(), 485040.0, 1e-6);
  EXPECT_THROW(node_surface(road, crg::Grid{}), Error);
}

TEST(WriteSurface, CloudAndMeshReadersPutItBackIntoTheMap) {
  const support::TemporaryFolder folder;
  const crg::Crg road = tilted();
  const NodeSurface surface = node_surface(road, deviations(road));
  for (const bool doubles : {false, true})
    for (const char* name : {"road.ply", "road.pcd"}) {
      SCOPED_TRACE(name);
      write_surface(surface, folder.path(name), doubles, {"a note\nof two lines"});
      const Cloud cloud = read_cloud(folder.path(name));
      ASSERT_EQ(cloud.size(), surface.place_m.size());
      double worst = 0.0;
      for (std::size_t k = 0; k < cloud.size(); ++k)
        worst = std::max(
            worst,
            (cloud.origin_m + cloud.point(k) - surface.origin_m - surface.place_m[k]).norm());
      EXPECT_LT(worst, doubles ? 1e-8 : 4e-6);  // float32 at 40 m: 2e-6
    }
  road::MeshReadOptions read;
  read.up = road::UpAxis::z;
  for (const bool doubles : {false, true}) {
    write_surface(surface, folder.path("road.ply"), doubles);
    road::MeshReadReport report;
    const road::Mesh mesh = road::read_mesh(folder.path("road.ply"), read, &report);
    ASSERT_EQ(mesh.triangles.size(), surface.triangles.size());
    EXPECT_LT(report.coordinate_resolution_m, 1e-5);
    double worst = 0.0;
    for (std::size_t k = 0; k < surface.place_m.size(); ++k)
      worst = std::max(
          worst,
          (mesh.origin_m + mesh.vertices_m[k] - surface.origin_m - surface.place_m[k]).norm());
    EXPECT_LT(worst, 4e-6);
  }
}

TEST(WriteSurface, RefusesOtherEndingsAndBrokenOrigins) {
  const support::TemporaryFolder folder;
  EXPECT_THROW(write_surface({}, folder.path("road.obj")), Error);
  folder.file("broken.ply",
              "ply\nformat binary_little_endian 1.0\ncomment origin_m 1 nan 3\nelement vertex "
              "0\nproperty float x\nproperty float y\nproperty float z\nend_header\n");
  EXPECT_ANY_THROW(road::read_mesh(folder.path("broken.ply")));
}

}  // namespace write_surface_test
}  // namespace cloud
