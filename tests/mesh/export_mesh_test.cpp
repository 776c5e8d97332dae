#include "mesh/export_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <set>

#include "mesh/error.h"
#include "support/temporary_folder.h"

namespace export_mesh_test {

using Eigen::Vector3d;
using road::Mesh;
using road::Unit;
using road::UpAxis;

/// A road of two objects that share an edge, a slope in x so that axes and signs cannot hide.
Mesh two_objects() {
  Mesh mesh;
  mesh.origin_m = {100, 200, 5};
  mesh.objects = {{"road one", "asphalt", "asphalt.png"}, {"kerb", "red white", ""}};
  for (int i = 0; i <= 300; ++i) {
    for (const double y : {-6.0, 6.0, 8.0}) mesh.vertices_m.emplace_back(10.0 * i, y, 0.01 * i);
  }
  for (std::uint32_t i = 0; i < 300; ++i) {
    for (std::uint32_t strip = 0; strip < 2; ++strip) {
      const std::uint32_t a = 3 * i + strip;
      mesh.triangles.push_back({a, a + 3, a + 4});
      mesh.triangles.push_back({a, a + 4, a + 1});
      mesh.object_of_triangle.insert(mesh.object_of_triangle.end(), 2, strip);
    }
  }
  return mesh;
}

/// Distance of each corner of `seen` from the nearest corner of `wanted`, worst of all.
double worst_corner(const Mesh& seen, const Mesh& wanted) {
  double worst = 0.0;
  for (std::size_t t = 0; t < seen.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Vector3d p = seen.origin_m + seen.vertex(t, k);
      double nearest = 1e9;
      for (const Vector3d& v : wanted.vertices_m)
        nearest = std::min(nearest, (wanted.origin_m + v - p).norm());
      worst = std::max(worst, nearest);
    }
  }
  return worst;
}

struct Case {
  const char* ending;
  UpAxis up;
  Unit unit;
  double tolerance_m;  ///< float32 at 3 km: half of 0.25 mm. Text in metres is exact here; 10,000
                       ///< ft pass the reader in float32 relative to their middle: half of 0.15 mm
};

class ExportMesh : public testing::TestWithParam<Case> {};

TEST_P(ExportMesh, ComesBackTheSame) {
  const Case& c = GetParam();
  const support::TemporaryFolder folder;
  const std::string path = folder.path(std::string("mesh") + c.ending);
  const Mesh mesh = two_objects();
  export_mesh(mesh, path, {c.up, c.unit});
  const Mesh back = road::read_mesh(path, {c.up, c.unit});
  EXPECT_EQ(back.triangles.size(), mesh.triangles.size());
  EXPECT_LT(worst_corner(back, mesh), c.tolerance_m);
  Vector3d normal = Vector3d::Zero();
  for (std::size_t t = 0; t < back.triangles.size(); ++t) {
    normal += (back.vertex(t, 1) - back.vertex(t, 0)).cross(back.vertex(t, 2) - back.vertex(t, 0));
  }
  EXPECT_GT(normal.z(), 0.0);
}

std::string case_name(const testing::TestParamInfo<Case>& info) {
  static constexpr std::array<const char*, 5> kUnits{"automatic", "m", "cm", "mm", "ft"};
  return std::string(info.param.ending).substr(1) + (info.param.up == UpAxis::y ? "_y_" : "_z_") +
         kUnits[static_cast<std::size_t>(info.param.unit)];
}

INSTANTIATE_TEST_SUITE_P(Formats, ExportMesh,
                         testing::Values(Case{".obj", UpAxis::y, Unit::m, 1e-5},
                                         Case{".obj", UpAxis::z, Unit::mm, 1e-5},
                                         Case{".obj", UpAxis::z, Unit::ft, 1e-4},
                                         Case{".glb", UpAxis::y, Unit::m, 2.5e-4},
                                         Case{".glb", UpAxis::z, Unit::cm, 2.5e-4},
                                         Case{".ply", UpAxis::y, Unit::cm, 1e-9},
                                         Case{".ply", UpAxis::z, Unit::m, 1e-9},
                                         Case{".stl", UpAxis::y, Unit::m, 2.5e-4},
                                         Case{".stl", UpAxis::z, Unit::ft, 2.5e-4}),
                         case_name);

TEST(ExportMesh, KeepsNames) {
  for (const char* ending : {".obj", ".glb"}) {
    const support::TemporaryFolder folder;
    const std::string path = folder.path(std::string("mesh") + ending);
    export_mesh(two_objects(), path, {});
    const Mesh back = road::read_mesh(path, {UpAxis::z, Unit::m});
    std::set<std::string> objects, materials;
    for (const road::MeshObject& object : back.objects) {
      objects.insert(object.name);
      materials.insert(object.material);
    }
    const bool blanks = std::string(ending) == ".glb";  // .obj names end at a blank
    EXPECT_EQ(objects, (std::set<std::string>{blanks ? "road one" : "road_one", "kerb"})) << ending;
    EXPECT_EQ(materials, (std::set<std::string>{"asphalt", blanks ? "red white" : "red_white"}))
        << ending;
  }
}

TEST(ExportMesh, NamelessIsOneObject) {
  Mesh mesh = two_objects();
  for (road::MeshObject& object : mesh.objects) object = {};
  const support::TemporaryFolder folder;
  const std::string path = folder.path("nameless.obj");
  export_mesh(mesh, path, {});
  const Mesh back = road::read_mesh(path, {UpAxis::z, Unit::m});
  EXPECT_EQ(back.triangles.size(), mesh.triangles.size());
  EXPECT_EQ(back.objects.size(), 1U);
  EXPECT_FALSE(std::filesystem::exists(folder.path("nameless.mtl")));
}

TEST(ExportMesh, RefusesWhatItCannotWrite) {
  using testing::HasSubstr;
  using testing::ThrowsMessage;
  EXPECT_THAT([] { export_mesh(Mesh{}, "/tmp/x.obj", {}); },
              ThrowsMessage<road::Error>(HasSubstr("no triangles")));
  EXPECT_THAT([] { export_mesh(two_objects(), "/tmp/x.fbx", {}); },
              ThrowsMessage<road::Error>(HasSubstr(".fbx")));
  EXPECT_THAT([] { export_mesh(two_objects(), "/nowhere/x.obj", {}); },
              ThrowsMessage<road::Error>(HasSubstr("/nowhere/x")));
}

TEST(ExportMesh, ObjectsOfOneMaterialKeepTheirOwnTextures) {
  Mesh mesh = two_objects();
  mesh.objects = {{"wall", "ac3d", "barrier.png"}, {"road", "ac3d", "asphalt.png"}};
  const support::TemporaryFolder folder;
  export_mesh(mesh, folder.path("m.obj"), {UpAxis::z, Unit::m});
  const Mesh seen = road::read_mesh(folder.path("m.obj"), {UpAxis::z, Unit::m});
  ASSERT_EQ(seen.objects.size(), 2u);
  EXPECT_EQ(seen.objects[0].texture, "barrier.png");
  EXPECT_EQ(seen.objects[1].texture, "asphalt.png");
}

}  // namespace export_mesh_test
