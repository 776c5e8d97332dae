#include "decide_up.h"

#include <fmt/format.h>

#include "mesh/error.h"
#include "mesh/read_mesh.h"
#include "support/mesh_files.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace decide_up_test {

using road::Mesh;
using road::MeshReadOptions;
using road::MeshReadReport;
using road::UpAxis;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using support::as_glb;
using support::as_obj;
using support::small_road;

/// As a file has it in which `up` points up; a rotation.
Mesh turned(Mesh mesh, UpAxis up) {
  for (auto& v : mesh.vertices_m) v = turned_from_z(v, up);
  return mesh;
}

Mesh with_faces_turned_over(Mesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

Mesh from_both_sides(Mesh mesh) {
  const Mesh other = with_faces_turned_over(mesh);
  mesh.triangles.insert(mesh.triangles.end(), other.triangles.begin(), other.triangles.end());
  mesh.object_of_triangle.insert(mesh.object_of_triangle.end(), other.object_of_triangle.begin(),
                                 other.object_of_triangle.end());
  return mesh;
}

/// In the order in which a reader gives them: one object after the other.
Mesh by_object(const Mesh& mesh) {
  Mesh out = mesh;
  out.triangles.clear();
  for (std::uint32_t object = 0; object < mesh.objects.size(); ++object)
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      if (mesh.object_of_triangle[t] == object) out.triangles.push_back(mesh.triangles[t]);
  return out;
}

/// Of the corners of all triangles in their order.
double largest_distance_m(const Mesh& expected, const Mesh& seen) {
  double worst = expected.triangles.size() == seen.triangles.size() ? 0.0 : 1e9;
  for (std::size_t t = 0; worst < 1e9 && t < expected.triangles.size(); ++t)
    for (int c = 0; c < 3; ++c)
      worst = std::max(
          worst,
          (expected.origin_m + expected.vertex(t, c) - seen.origin_m - seen.vertex(t, c)).norm());
  return worst;
}

class DecideUp : public ::testing::Test {
 protected:
  Mesh read(const std::string& name, const std::string& bytes,
            const MeshReadOptions& options = {}) {
    return road::read_mesh(folder_.file(name, bytes), options, &report_);
  }
  support::TemporaryFolder folder_;
  const Mesh road_ = small_road();
  MeshReadReport report_;
};

TEST_F(DecideUp, FindsEachOfSixAxesAndKeepsLeftOnTheLeft) {
  for (const auto& [up, name] : road::kUps) {
    const Mesh seen = read("a.obj", as_obj(turned(road_, up)));
    EXPECT_EQ(report_.up, name);
    EXPECT_EQ(report_.up_why, "from the faces of 40 triangles");
    EXPECT_LT(largest_distance_m(by_object(road_), seen), 1e-5) << name;
    MeshReadOptions told;
    told.up = up;
    EXPECT_LT(largest_distance_m(by_object(road_), read("a.obj", as_obj(turned(road_, up)), told)),
              1e-5);
    EXPECT_EQ(report_.up_why, "as told");
    EXPECT_THAT(report_.remarks, IsEmpty());
  }
}

TEST_F(DecideUp, TurnsBackWhatItTurned) {
  const Eigen::Vector3d p(1.0, 2.0, 3.0);
  for (const auto& [up, name] : road::kUps) {
    EXPECT_EQ(turned_up(turned_from_z(p, up), up), p) << name;
    EXPECT_EQ(turned_up(Eigen::Vector3d::Unit(line_of(up)) * (is_minus(up) ? -1.0 : 1.0), up),
              Eigen::Vector3d::UnitZ())
        << name;
    EXPECT_EQ(road::up_called(name), up);
    Eigen::Matrix3d turn;
    for (int k = 0; k < 3; ++k) turn.col(k) = turned_up(Eigen::Vector3d::Unit(k), up);
    EXPECT_EQ(turn.determinant(), 1.0) << name;
  }
}

TEST_F(DecideUp, MirrorsWhenTold) {
  Mesh mirrored = road_;
  for (auto& v : mirrored.vertices_m) v.y() = -v.y();
  mirrored = with_faces_turned_over(mirrored);
  MeshReadOptions options;
  options.mirror = true;
  for (const auto& [up, name] : road::kUps) {
    const Mesh seen = read("a.obj", as_obj(turned(mirrored, up)), options);
    EXPECT_EQ(report_.up, name);
    EXPECT_TRUE(report_.mirrored);
    EXPECT_LT(largest_distance_m(by_object(road_), seen), 1e-5) << name;
  }
}

TEST_F(DecideUp, TakesTheFormatsWordWhereFacesLookBothWays) {
  read("a.glb", as_glb(from_both_sides(road_)));
  EXPECT_EQ(report_.up, "y");
  EXPECT_EQ(report_.up_why, "as glTF files have it; faces look both ways");
  EXPECT_THAT(report_.remarks, IsEmpty());
  read("a.obj", as_obj(from_both_sides(turned(road_, UpAxis::minus_z))));
  EXPECT_EQ(report_.up, "z");
  EXPECT_EQ(report_.up_why, "from the faces of 80 triangles, which look both ways");
}

TEST_F(DecideUp, AsksWhetherAMeshThatViewersShowFromBelowIsMirrored) {
  try {
    read("a.glb", as_glb(with_faces_turned_over(road_)));
    FAIL();
  } catch (const road::UnknownUp& unknown) {
    EXPECT_EQ(unknown.could_be(), (std::vector{UpAxis::y, UpAxis::minus_y}));
    EXPECT_THAT(unknown.what(), AllOf(HasSubstr("but up is y, as glTF files have it"),
                                      HasSubstr("give --up y --mirror (left and right")));
  }
}

TEST_F(DecideUp, FollowsTheFacesToAnotherLineThanTheFormats) {
  // as_glb() turns z to y.
  const Mesh seen = read("a.glb", as_glb(turned(turned(road_, UpAxis::minus_z), UpAxis::minus_y)));
  EXPECT_EQ(report_.up, "-z");
  EXPECT_THAT(report_.remarks, Contains(AllOf(HasSubstr("the format says y is up"),
                                              HasSubstr("took -z"), HasSubstr("give --up z"))));
  EXPECT_LT(largest_distance_m(by_object(road_), seen), 1e-4);
}

/// A road of 200 m without anything that stands on it; with ground 0.2 m below, or without.
Mesh lying(bool on_ground) {
  Mesh mesh = small_road();
  std::erase_if(mesh.object_of_triangle, [](std::uint32_t object) { return object == 1; });
  std::vector<std::array<std::uint32_t, 3>> level;
  for (const auto& t : mesh.triangles)
    if (t[0] % 3 != 2 && t[1] % 3 != 2 && t[2] % 3 != 2) level.push_back(t);
  mesh.triangles = level;
  mesh.objects.resize(1);
  if (!on_ground) return mesh;
  const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
  for (const double x : {-20.0, 220.0})
    for (const double y : {-30.0, 30.0}) mesh.vertices_m.emplace_back(x, y, 0.02 * x - 0.2);
  mesh.triangles.push_back({first, first + 2, first + 1});
  mesh.triangles.push_back({first + 1, first + 2, first + 3});
  mesh.object_of_triangle.insert(mesh.object_of_triangle.end(), 2, 1);
  mesh.objects.push_back({"ground", "grass", ""});
  return mesh;
}

TEST_F(DecideUp, AsksWhereFacesLookDownAndNothingStandsOnThem) {
  const Mesh bare = lying(false);
  Mesh mirrored = bare;
  for (auto& v : mirrored.vertices_m) v.y() = -v.y();
  for (const Mesh& mesh : {turned(bare, UpAxis::minus_z), mirrored}) {
    try {
      read("a.obj", as_obj(mesh));
      FAIL();
    } catch (const road::UnknownUp& unknown) {
      EXPECT_EQ(unknown.could_be(), (std::vector{UpAxis::minus_z, UpAxis::z}));
      EXPECT_THAT(unknown.what(), AllOf(HasSubstr("give --up -z (it lies on its back)"),
                                        HasSubstr("--up z --mirror (left and right exchanged)")));
    }
  }
}

TEST_F(DecideUp, ASmallObjectLiesOnALargeOne) {
  read("a.obj", as_obj(turned(lying(true), UpAxis::minus_z)));
  EXPECT_EQ(report_.up, "-z");
  Mesh mirrored = lying(true);
  for (auto& v : mirrored.vertices_m) v.y() = -v.y();
  try {
    read("a.obj", as_obj(mirrored));
    FAIL();
  } catch (const road::UnknownUp& unknown) {
    EXPECT_EQ(unknown.could_be(), (std::vector{UpAxis::z, UpAxis::minus_z}));
    EXPECT_THAT(unknown.what(), HasSubstr("small objects lie on large ones towards z"));
  }
}

TEST_F(DecideUp, SaysThatTheFacesLookAgainstWhatWasTold) {
  MeshReadOptions told;
  told.up = UpAxis::z;
  read("a.obj", as_obj(turned(road_, UpAxis::minus_z)), told);
  EXPECT_EQ(report_.up, "z");
  EXPECT_THAT(report_.remarks, Contains(HasSubstr("give --up -z")));
  told.up = UpAxis::y;
  try {
    read("a.obj", as_obj(turned(road_, UpAxis::minus_z)), told);
    FAIL();
  } catch (const road::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("told that y is up, but the large flat faces say -z"));
    EXPECT_THAT(error.what(), HasSubstr("give --up -z"));
  }
}

TEST_F(DecideUp, ObjectsMirroredInTheFileKeepTheirUpperSide) {
  std::string glb = as_glb(road_);
  ASSERT_NO_THROW(read("plain.glb", glb));
  // The plan as it was, by an object that is mirrored twice over: x in the node, x in its vertices.
  Mesh mirrored = road_;
  for (auto& v : mirrored.vertices_m) v.x() = -v.x();
  glb = as_glb(with_faces_turned_over(mirrored));
  const std::string node = "\"mesh\":";
  ASSERT_NE(glb.find(node), std::string::npos);
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof length);
  std::string json = glb.substr(20, length);
  for (std::size_t at = json.find(node); at != std::string::npos; at = json.find(node, at + 30))
    json.insert(at, "\"scale\":[-1,1,1],");
  const std::string bytes = folder_.file("a.bin", glb.substr(20 + length + 8));
  json.insert(json.find("\"buffers\":[{") + 12, "\"uri\":\"a.bin\",");
  const Mesh seen = read("a.gltf", json);
  EXPECT_EQ(report_.up_why, "from the faces of 40 triangles");
  EXPECT_THAT(report_.remarks, IsEmpty());
}

/// A square of 20 m x 20 m that looks to `up` of the axes that it states.
std::string as_fbx(int up, int up_sign, int front, int front_sign, int right, int right_sign,
                   const Mesh& mesh) {
  const auto number = [](const char* name, const char* type, auto value) {
    return fmt::format("    P: \"{}\", \"{}\", \"\", \"\",{}\n", name, type, value);
  };
  std::string vertices, corners;
  for (const auto& v : mesh.vertices_m)
    vertices += fmt::format("{}{},{},{}", vertices.empty() ? "" : ",", v.x(), v.y(), v.z());
  for (const auto& t : mesh.triangles)
    corners += fmt::format("{}{},{},{}", corners.empty() ? "" : ",", t[0], t[1],
                           -1 - static_cast<int>(t[2]));
  return "; FBX 7.4.0 project file\nFBXHeaderExtension:  {\n  FBXVersion: 7400\n}\n"
         "GlobalSettings:  {\n  Version: 1000\n  Properties70:  {\n" +
         number("UpAxis", "int", up) + number("UpAxisSign", "int", up_sign) +
         number("FrontAxis", "int", front) + number("FrontAxisSign", "int", front_sign) +
         number("CoordAxis", "int", right) + number("CoordAxisSign", "int", right_sign) +
         number("UnitScaleFactor", "double", 100.0) +
         fmt::format(
             "  }}\n}}\nObjects:  {{\n  Geometry: 1, \"Geometry::road\", \"Mesh\" {{\n"
             "    Vertices: *{} {{\n      a: {}\n    }}\n"
             "    PolygonVertexIndex: *{} {{\n      a: {}\n    }}\n  }}\n"
             "  Model: 2, \"Model::road\", \"Mesh\" {{\n    Version: 232\n  }}\n}}\n"
             "Connections:  {{\n  C: \"OO\",2,0\n  C: \"OO\",1,2\n}}\n",
             3 * mesh.vertices_m.size(), vertices, 3 * mesh.triangles.size(), corners);
}

TEST_F(DecideUp, ReadsTheAxesThatAnFbxStates) {
  const Mesh both = from_both_sides(road_);
  const auto from = [&](UpAxis up, auto... axes) {
    return read("a.fbx", as_fbx(axes..., turned(both, up)));
  };
  EXPECT_LT(largest_distance_m(both, from(UpAxis::y, 1, 1, 2, 1, 0, 1)), 1e-4);
  EXPECT_EQ(report_.up, "y");
  EXPECT_LT(largest_distance_m(both, from(UpAxis::z, 2, 1, 1, -1, 0, 1)), 1e-4);
  EXPECT_EQ(report_.up, "z");
  EXPECT_LT(largest_distance_m(both, from(UpAxis::minus_z, 2, -1, 1, 1, 0, 1)), 1e-4);
  EXPECT_EQ(report_.up, "-z") << "stated, as faces look both ways";
  EXPECT_EQ(report_.up_why, "as the file states; faces look both ways");
  EXPECT_THAT(report_.remarks, IsEmpty());
}

TEST_F(DecideUp, TakesInvertedWindingAlongTheFormatsOwnLineForThat) {
  read("a.fbx", as_fbx(2, 1, 1, -1, 0, 1, with_faces_turned_over(road_)));
  EXPECT_EQ(report_.up, "z");
  EXPECT_EQ(report_.up_why, "as the file states; faces look to -z");
  EXPECT_THAT(report_.remarks, Contains(AllOf(HasSubstr("100 % of the flat faces look to -z"),
                                              HasSubstr("give --up -z"))));
}

TEST_F(DecideUp, MirrorsAnFbxThatStatesAxesOfTheLeftHand) {
  Mesh left = road_;
  for (auto& v : left.vertices_m) v.y() = -v.y();
  left = with_faces_turned_over(left);
  const Mesh seen = read("a.fbx", as_fbx(2, 1, 1, 1, 0, 1, left));
  EXPECT_LT(largest_distance_m(road_, seen), 1e-4);
  EXPECT_THAT(report_.remarks, Contains(HasSubstr("axes of the left hand")));
}

/// A road on walls of 30 m, closed on all sides: 80 by 80 m, 5 m wide.
Mesh body_on_walls() {
  Mesh mesh;
  mesh.objects.resize(1);
  const auto at = [](double half_m, int corner, double z_m) {
    return Eigen::Vector3d(corner % 3 == 0 ? -half_m : half_m, corner < 2 ? -half_m : half_m, z_m);
  };
  for (const auto& [half_m, z_m] : {std::pair(40.0, 30.0), {35.0, 30.0}, {35.0, 0.0}, {40.0, 0.0}})
    for (int corner = 0; corner < 4; ++corner) mesh.vertices_m.push_back(at(half_m, corner, z_m));
  for (std::uint32_t side = 0; side < 4; ++side)
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
      const std::uint32_t a = 4 * side + corner, b = 4 * side + (corner + 1) % 4, c = (a + 4) % 16,
                          d = (b + 4) % 16;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({b, d, c});
      mesh.object_of_triangle.insert(mesh.object_of_triangle.end(), 2, 0);
    }
  return mesh;
}

TEST_F(DecideUp, WallsThatFaceEachOtherDecideNothing) {
  const Mesh body = body_on_walls();
  EXPECT_THROW(read("a.obj", as_obj(body)), road::UnknownUp);
  MeshReadOptions told;
  told.up = UpAxis::z;
  EXPECT_LT(largest_distance_m(body, read("a.obj", as_obj(body), told)), 1e-5);
  EXPECT_EQ(report_.up_why, "as told");
}

TEST(DecideUpReal, TheCircuitsThatLieOnTheirBack) {
  const std::filesystem::path folder = places::data() + "/f1";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  std::size_t read = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".glb") continue;
    MeshReadReport report;
    road::read_mesh(entry.path(), {}, &report);
    EXPECT_EQ(report.up, "-z") << entry.path();
    ++read;
  }
  EXPECT_EQ(read, 10u);
}

TEST(DecideUpReal, MeshesThatWereReadTheRightWayUpStillAre) {
  const std::filesystem::path data = places::data();
  if (!std::filesystem::exists(data / "meshes2")) GTEST_SKIP() << data << " is not there";
  for (const auto& [file, up] : {std::pair{"meshes/stk_islandtrack.b3d", "y"},  // a sea from below
                                 {"meshes/stk_hacienda.b3d", "y"},
                                 {"meshes/superdrift_racetrack.glb", "y"},
                                 {"meshes/mcity.obj", "z"},
                                 {"meshes2/brean_track.fbx", "y"},  // its winding is inverted
                                 {"meshes2/urjc_track4.fbx", "y"},
                                 {"meshes2/keshav_track.obj", "y"},
                                 {"constructed/ring_r200_mirrored_node.glb", "y"}}) {
    MeshReadReport report;
    road::read_mesh(data / file, {}, &report);
    EXPECT_EQ(report.up, up) << file;
  }
}

}  // namespace decide_up_test
