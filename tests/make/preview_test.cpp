#include "make/preview.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numeric>

#include "base/json_text.h"
#include "mesh/error.h"
#include "mesh/export_mesh.h"
#include "support/ring_strips.h"
#include "support/temporary_folder.h"

namespace preview_test {

using ::testing::HasSubstr;

/// A road of 10 m with a kerb of 1 m beside it, far from the origin.
road::Recipe ring(const support::TemporaryFolder& folder) {
  road::Mesh mesh;
  support::add_ring_strip(mesh, "road", -5.0, 5.0, 0.0, 0.0);
  support::add_ring_strip(mesh, "kerb \"1\" <b>", 5.0, 6.0, 0.0, 0.05);
  mesh.origin_m = {500'000.0, 4'000'000.0, 100.0};
  const std::string path = folder.path("ring.obj");
  road::export_mesh(mesh, path);
  return road::recipe_for_mesh(path);
}

double area_m2(const road::PreviewPart& part) {
  double area = 0.0;
  const auto at = [&](std::size_t corner) {
    const float* const p = &part.positions_m[3 * part.indices[corner]];
    return Eigen::Vector3d(p[0], p[1], p[2]);
  };
  for (std::size_t t = 0; t < part.indices.size(); t += 3) {
    const Eigen::Vector3d a = at(t + 1) - at(t), b = at(t + 2) - at(t);
    area += 0.5 * std::abs(a.x() * b.y() - a.y() * b.x());
  }
  return area;
}

TEST(Preview, TellsObjectsByWhatTheyAre) {
  support::TemporaryFolder folder;
  const road::Preview preview = road::preview(ring(folder));
  EXPECT_EQ(preview.refusal, "");
  EXPECT_EQ(preview.told_by, "names");
  ASSERT_EQ(preview.parts.size(), 2U);
  EXPECT_EQ(preview.parts[0].surface_class, "road");
  EXPECT_EQ(preview.parts[1].surface_class, "kerb");
  // Rings of 95 to 105 m and 94 to 95 m, less what chords of 1 m cut off.
  EXPECT_NEAR(preview.parts[0].area_m2, M_PI * (105.0 * 105.0 - 95.0 * 95.0), 1.0);
  EXPECT_NEAR(area_m2(preview.parts[1]), M_PI * (95.0 * 95.0 - 94.0 * 94.0), 0.1);
  const Eigen::Vector3d first = preview.origin_m + Eigen::Vector3d(preview.parts[0].positions_m[0],
                                                                   preview.parts[0].positions_m[1],
                                                                   preview.parts[0].positions_m[2]);
  EXPECT_NEAR((first.head<2>() - Eigen::Vector2d(500'000.0, 4'000'000.0)).norm(), 100.0, 5.1);
  EXPECT_EQ(preview.triangles_in, preview.triangles_shown);
}

TEST(Preview, SaysNothingOfClassesWhereNotAsked) {
  support::TemporaryFolder folder;
  const road::Preview preview =
      road::preview(ring(folder), road::kPreviewTriangles, road::PreviewClasses::none);
  ASSERT_EQ(preview.parts.size(), 2U);
  EXPECT_EQ(preview.parts[0].surface_class, "unknown");
  EXPECT_EQ(preview.refusal + preview.told_by, "");
  EXPECT_EQ(preview.triangles_shown, 2516U);
}

TEST(Preview, ThinsEveryPartAndKeepsItsShape) {
  support::TemporaryFolder folder;
  const road::Preview preview = road::preview(ring(folder), 400);
  EXPECT_EQ(preview.triangles_in, 2516U);
  EXPECT_LE(preview.triangles_shown, 800U);
  ASSERT_EQ(preview.parts.size(), 2U);
  for (const road::PreviewPart& part : preview.parts) {
    EXPECT_GT(part.indices.size(), 0U);
    for (const std::uint32_t index : part.indices) EXPECT_LT(index, part.positions_m.size() / 3);
  }
  // A few hundred triangles follow the ring within a part in fifty.
  EXPECT_NEAR(area_m2(preview.parts[0]), preview.parts[0].area_m2, 0.02 * preview.parts[0].area_m2);
  EXPECT_EQ(road::glb_of(preview), road::glb_of(road::preview(ring(folder), 400)));
}

TEST(Preview, ShowsAMeshOfWhichNoRoadCanBeMade) {
  support::TemporaryFolder folder;
  road::Mesh mesh;  // two circuits, each as good as the other
  support::add_ring_strip(mesh, "road", -5.0, 5.0, 0.0, 0.0);
  const std::size_t vertices = mesh.vertices_m.size();
  support::add_ring_strip(mesh, "road", -5.0, 5.0, 0.0, 0.0);
  for (std::size_t k = vertices; k < mesh.vertices_m.size(); ++k) mesh.vertices_m[k].x() += 1000.0;
  const std::string path = folder.path("two.obj");
  road::export_mesh(mesh, path);
  const road::Preview preview = road::preview(road::recipe_for_mesh(path));
  EXPECT_THAT(preview.refusal, HasSubstr("near-m"));
  for (const road::PreviewPart& part : preview.parts) EXPECT_EQ(part.surface_class, "unknown");
  EXPECT_EQ(preview.triangles_shown, mesh.triangles.size());
  EXPECT_THROW(road::preview(road::recipe_for_mesh(folder.path("missing.obj"))), road::Error);
}

TEST(Preview, IsAGlbThatReadsBackAsTheSameMesh) {
  support::TemporaryFolder folder;
  const road::Preview preview = road::preview(ring(folder));
  const std::string glb = road::glb_of(preview);
  std::uint32_t words[5];
  std::memcpy(words, glb.data(), sizeof words);
  EXPECT_EQ(glb.substr(0, 4), "glTF");
  EXPECT_EQ(words[2], glb.size());
  const nlohmann::json json = base::parse_json<nlohmann::json>(glb.substr(20, words[3]));
  EXPECT_EQ(json["scenes"][0]["extras"]["origin_m"][0], preview.origin_m.x());
  EXPECT_EQ(json["nodes"][1]["extras"]["class"], "kerb");
  EXPECT_THAT(base::dump_json(json["scenes"][0]["extras"]["objects"]), HasSubstr("kerb"));
  // Another reader (assimp) sees as many triangles, the right way up.
  folder.file("ring.glb", glb);
  const road::Mesh mesh = road::read_mesh(folder.path("ring.glb"));
  EXPECT_EQ(mesh.triangles.size(), preview.triangles_in);
  double low = 1e9, high = -1e9;
  for (const Eigen::Vector3d& v : mesh.vertices_m) {
    low = std::min(low, v.z());
    high = std::max(high, v.z());
  }
  EXPECT_NEAR(high - low, 0.05, 1e-4);
}

}  // namespace preview_test
