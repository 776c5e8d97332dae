// The damages that other tests plant are what they say, and damaged files of two parts are read or
// refused.
#include "support/mutate_mesh.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>

#include "fuzz/mutated.h"
#include "mesh/error.h"
#include "mesh/read_mesh.h"
#include "support/analytic_roads.h"
#include "support/brute_force.h"
#include "support/draco_gltf.h"
#include "support/gltf_parts.h"
#include "support/mesh_files.h"
#include "support/temporary_folder.h"

namespace mutate_mesh_test {

using Eigen::Vector2d;
using Eigen::Vector3d;
using road::Mesh;

Mesh straight() { return support::flat_straight(200, 5).mesh; }

double area(const Mesh& mesh) {
  double sum = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    sum +=
        0.5 *
        (mesh.vertex(t, 1) - mesh.vertex(t, 0)).cross(mesh.vertex(t, 2) - mesh.vertex(t, 0)).norm();
  }
  return sum;
}

TEST(MutateMesh, JitterMovesVerticesAndKeepsSharedEdgesShut) {
  const Mesh before =
      support::stadium_with_kerb().mesh;  // road and kerb have their own vertices on the edge
  const Mesh after = support::jitter(before, 0.001, 3);
  double largest = 0.0;
  for (std::size_t i = 0; i < before.vertices_m.size(); ++i) {
    largest = std::max(largest, (after.vertices_m[i] - before.vertices_m[i]).cwiseAbs().maxCoeff());
    for (std::size_t j = i + 1; j < before.vertices_m.size(); ++j) {
      if (before.vertices_m[i] == before.vertices_m[j]) {
        EXPECT_EQ(after.vertices_m[i], after.vertices_m[j]);
      }
    }
  }
  EXPECT_LE(largest, 0.001);
  EXPECT_GT(largest, 0.00095);
}

TEST(MutateMesh, SharesOfTriangles) {
  const Mesh mesh = support::figure_eight().mesh;
  const auto n = static_cast<double>(mesh.triangles.size());
  const double removed =
      n - static_cast<double>(support::delete_triangles(mesh, 0.05, 1).triangles.size());
  const double added =
      static_cast<double>(support::duplicate_triangles(mesh, 0.05, 1).triangles.size()) - n;
  // Three standard deviations of a binomial draw.
  const double spread = 3 * std::sqrt(n * 0.05 * 0.95);
  EXPECT_NEAR(removed, 0.05 * n, spread);
  EXPECT_NEAR(added, 0.05 * n, spread);
  const Mesh flipped = support::flip_triangles(mesh, 1.0, 1);
  EXPECT_EQ(flipped.triangles[7][1], mesh.triangles[7][2]);
}

TEST(MutateMesh, FramesAreExact) {
  const Mesh moved =
      support::move_rigidly(straight(), std::numbers::pi / 2, {450000, 5300000, 100});
  const support::BruteForce ruler(moved);
  EXPECT_NEAR(ruler.nearest(450003, 5300150, 100).value_or(0), 100, 1e-9);
  EXPECT_FALSE(ruler.nearest(450150, 5300003, 100));
  EXPECT_NEAR(area(support::scale(straight(), 1000)), 2000e6, 1.0);
  EXPECT_EQ(support::strip_names(straight()).objects.at(0).name, "");
}

TEST(MutateMesh, TileHoleAndCrackLieWherePlanted) {
  const Mesh tile = support::lift_tile(straight(), {60, -10}, {101, 10}, 0.02);
  const support::BruteForce ruler(tile);
  EXPECT_NEAR(*ruler.nearest(80, 1, 0), 0.02, 1e-12);
  EXPECT_NEAR(*ruler.nearest(57.5, 1, 0), 0.01, 1e-12);  // the facet from 55 to 60 m is the step
  EXPECT_NEAR(*ruler.nearest(110, 1, 0), 0.0, 1e-12);

  const Mesh hole = support::punch_hole(straight(), {120.3, -2.7}, 0.025, NAN);
  const double missing = area(straight()) - area(hole);
  EXPECT_NEAR(missing, std::numbers::pi * 0.025 * 0.025, 0.15 * std::numbers::pi * 0.025 * 0.025);
  const support::BruteForce holed(hole);
  EXPECT_FALSE(holed.nearest(120.3, -2.7, 0));
  EXPECT_TRUE(holed.nearest(120.33, -2.7, 0));
  EXPECT_EQ(support::punch_hole(straight(), {120.3, -2.7}, 0.025, 50.0).triangles.size(),
            straight().triangles.size());

  const support::BruteForce cracked(support::crack(straight(), 100.0, 0.002));
  EXPECT_FALSE(cracked.nearest(100.001, 1.3, 0));
  EXPECT_TRUE(cracked.nearest(99.999, 1.3, 0));
  EXPECT_TRUE(cracked.nearest(100.003, 1.3, 0));
}

TEST(AnalyticRoads, FacetsAreAsNearAsStated) {
  for (const support::AnalyticRoad& road :
       {support::flat_straight(), support::banked_circle(), support::wavy_straight(),
        support::stadium_with_kerb(), support::figure_eight()}) {
    const support::BruteForce ruler(road.mesh);
    double worst = 0.0;
    for (int i = 0; i < 3000; ++i) {
      const double u = road.length_m * (i + 0.37) / 3000;
      const double v = road.half_width_m * 0.99 * std::sin(i * 1.7);
      const crg::Point2 p = road.position_m(u, v);
      const auto z = ruler.nearest(p.x_m, p.y_m, road.z_m(u, v));
      ASSERT_TRUE(z) << road.name << " u " << u << " v " << v;
      worst = std::max(worst, std::abs(*z - road.z_m(u, v)));
    }
    EXPECT_LE(worst, road.facet_error_m * 1.01 + 1e-12) << road.name;
    EXPECT_GE(worst, road.facet_error_m * 0.3) << road.name;
  }
  EXPECT_NEAR(support::stadium_with_kerb().z_m(60, 5.9), 0.06, 1e-12);
}

/// Reads mutants of a mesh and of its companion, one or both damaged, in this process: a crash ends
/// the test. KERBSTONE_HEAVY=1: 10,000 of them; KERBSTONE_MUTANTS=N: N; KERBSTONE_FIRST_MUTANT=K:
/// from the K-th on, to look at one.
void read_mutants(const std::string& mesh_name, const std::string& mesh,
                  const std::string& companion_name, const std::string& companion,
                  double least_read_share = 0.05) {
  const auto number = [](const char* name, std::size_t otherwise) {
    const char* text = std::getenv(name);
    return text == nullptr ? otherwise : static_cast<std::size_t>(std::strtoul(text, nullptr, 10));
  };
  const std::size_t first = number("KERBSTONE_FIRST_MUTANT", 0);
  const std::size_t count =
      number("KERBSTONE_MUTANTS", std::getenv("KERBSTONE_HEAVY") ? 10'000 : 300);
  const support::TemporaryFolder folder;
  road::MeshReadOptions options;
  options.own_process = false;
  std::size_t read = 0;
  double longest_s = 0.0;
  for (std::size_t i = first; i < first + count; ++i) {
    std::mt19937_64 generator(i);
    folder.file(companion_name, i % 3 == 0 ? companion : fuzz::mutated(companion, generator));
    const std::string path =
        folder.file(mesh_name, i % 3 == 1 ? mesh : fuzz::mutated(mesh, generator));
    if (std::getenv("KERBSTONE_FIRST_MUTANT")) std::fprintf(stderr, "mutant %zu\n", i);
    const auto begin = std::chrono::steady_clock::now();
    try {
      const Mesh seen = road::read_mesh(path, options);
      ++read;
      ASSERT_EQ(seen.object_of_triangle.size(), seen.triangles.size()) << "mutant " << i;
      for (const auto& triangle : seen.triangles) {
        for (const std::uint32_t corner : triangle) {
          ASSERT_LT(corner, seen.vertices_m.size()) << "mutant " << i;
          ASSERT_TRUE(seen.vertices_m[corner].allFinite()) << "mutant " << i;
        }
      }
    } catch (const road::Error& error) {
      ASSERT_NE(std::string(error.what()).find(path), std::string::npos)
          << "mutant " << i << ": " << error.what();
    }
    longest_s = std::max(
        longest_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  EXPECT_LT(longest_s, 10.0);
  EXPECT_GT(static_cast<double>(read),
            least_read_share *
                static_cast<double>(
                    count));  // most damages are refused; if all were, nothing would be tested
  std::printf("%zu mutants, %zu read, longest %.3f s\n", count, read, longest_s);
}

TEST(MutateMesh, DamagedGltfAndItsBufferAreReadOrRefused) {
  const support::GltfAndBin parts = support::as_gltf(support::small_road(), "a.bin");
  read_mutants("a.gltf", parts.gltf, "a.bin", parts.bin);
}

TEST(MutateMesh, DamagedInstancesOfIntegersAreReadOrRefused) {
  const support::GltfAndBin parts = support::busy_gltf().with_bin("a.bin");
  read_mutants("a.gltf", parts.gltf, "a.bin", parts.bin);
}

TEST(MutateMesh, DamagedDracoIsReadOrRefused) {
  for (const support::DracoMethod method :
       {support::DracoMethod::edgebreaker, support::DracoMethod::sequential}) {
    const support::GltfAndBin parts =
        support::as_draco_gltf(support::small_road(), "a.bin", method, 12, true);
    read_mutants("a.gltf", parts.gltf, "a.bin", parts.bin,
                 0.02);  // hardly a damage of packed bytes leaves a mesh
  }
}

TEST(MutateMesh, DamagedObjAndItsMaterialsAreReadOrRefused) {
  read_mutants("a.obj", "mtllib a.mtl\n" + support::as_obj(support::small_road()), "a.mtl",
               "# painted\nnewmtl asphalt\nKa 0.1 0.2 0.3\nKd 0.8 0.8 0.8\nKs 0 0 0\nNs 10.5\nd "
               "0.9\nillum 2\n"
               "map_Kd -s 2 2 1 textures/asphalt.png\nbump -bm 0.5 rough.png\n\nnewmtl "
               "concrete\nKd 0.5 0.5 0.5\nTr 0.1\n"
               "map_Kd wall.png\nmap_Bump wall_bump.png\n");
}

}  // namespace mutate_mesh_test
