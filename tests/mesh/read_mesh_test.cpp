#include "mesh/read_mesh.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstring>
#include <filesystem>
#include <limits>
#include <set>

#include "base/sha256.h"
#include "mesh/error.h"
#include "support/mesh_files.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace read_mesh_test {

using road::Mesh;
using road::MeshReadOptions;
using road::MeshReadReport;
using ::testing::HasSubstr;

using support::as_acc;
using support::as_glb;
using support::as_gltf;
using support::as_obj;
using support::as_ply;
using support::as_stl;
using support::as_text_stl;
using support::small_road;

/// Largest distance of corresponding corners, in map coordinates; triangles may come in another
/// order.
double distance(const Mesh& expected, const Mesh& seen,
                const Eigen::Vector3d& offset = Eigen::Vector3d::Zero()) {
  if (expected.triangles.size() != seen.triangles.size())
    return std::numeric_limits<double>::infinity();
  double worst = 0.0;
  std::vector<bool> used(seen.triangles.size(), false);
  for (std::size_t i = 0; i < expected.triangles.size(); ++i) {
    double best = std::numeric_limits<double>::infinity();
    std::size_t best_index = 0;
    for (std::size_t j = 0; j < seen.triangles.size(); ++j) {
      if (used[j]) continue;
      for (int turn = 0; turn < 3; ++turn) {
        double most = 0.0;
        for (int c = 0; c < 3; ++c) {
          most = std::max(most, (expected.origin_m + expected.vertex(i, c) + offset -
                                 (seen.origin_m + seen.vertex(j, (c + turn) % 3)))
                                    .norm());
        }
        if (most < best) {
          best = most;
          best_index = j;
        }
      }
    }
    used[best_index] = true;
    worst = std::max(worst, best);
  }
  return worst;
}

std::string message_of(const std::string& path, const MeshReadOptions& options = {}) {
  try {
    road::read_mesh(path, options);
  } catch (const road::Error& error) {
    return error.what();
  }
  return "no error";
}

class ReadMesh : public ::testing::Test {
 protected:
  support::TemporaryFolder folder_;
  const Mesh road_ = small_road();
};

TEST_F(ReadMesh, GivesTheSameTrianglesFromEveryFormatAndAxis) {
  const std::vector<std::pair<std::string, std::string>> files{
      {"a.obj", as_obj(road_, 'z')},
      {"b.obj", as_obj(road_, 'y')},
      {"c.acc", as_acc(road_)},
      {"d.ac", as_acc(road_)},
      {"e.stl", as_stl(road_)},
      {"f.stl", as_stl(road_, Eigen::Vector3d::Zero(), "solid in name only")},
      {"g.stl", as_text_stl(road_)},
      {"h.ply", as_ply(road_, "ascii", "float")},
      {"i.ply", as_ply(road_, "binary_little_endian", "float")},
      {"j.ply", as_ply(road_, "binary_big_endian", "double")},
      {"k.glb", as_glb(road_)},
      {"L.OBJ", as_obj(road_, 'y')}};
  for (const auto& [name, bytes] : files) {
    MeshReadReport report;
    const Mesh seen = road::read_mesh(folder_.file(name, bytes), {}, &report);
    // 200 m in float32: 8 um.
    EXPECT_LT(distance(road_, seen), 2e-5) << name;
    EXPECT_EQ(report.triangles, road_.triangles.size()) << name;
    EXPECT_EQ(report.unit, "m") << name;
  }
}

TEST_F(ReadMesh, KeepsTheNamesThatFormatsHave) {
  const auto seen = [&](const std::string& name, const std::string& bytes) {
    const Mesh mesh = road::read_mesh(folder_.file(name, bytes));
    std::set<std::string> names;
    for (const std::uint32_t o : mesh.object_of_triangle) {
      names.insert(mesh.objects[o].name + "|" + mesh.objects[o].material + "|" +
                   mesh.objects[o].texture);
    }
    return names;
  };
  using Names = std::set<std::string>;
  EXPECT_EQ(seen("a.obj", as_obj(road_)), (Names{"road|asphalt|", "wall|concrete|"}));
  EXPECT_EQ(seen("a.glb", as_glb(road_)), (Names{"road|asphalt|", "wall|concrete|"}));
  // The texture is that of the "base" line, although "skids" and "shad" lines follow.
  EXPECT_EQ(seen("a.acc", as_acc(road_)), (Names{"road||asphalt.png", "wall||wall.png"}));
  EXPECT_EQ(seen("a.stl", as_stl(road_)), (Names{"||"}));
}

TEST_F(ReadMesh, ReadsMaterialTexturesBesideAnObj) {
  folder_.file("road.mtl", "newmtl asphalt\nmap_Kd textures/new_asphalt.png\nnewmtl concrete\n");
  const Mesh mesh = road::read_mesh(folder_.file("a.obj", "mtllib road.mtl\n" + as_obj(road_)));
  EXPECT_EQ(mesh.objects[mesh.object_of_triangle[0]].texture, "new_asphalt.png");
}

TEST_F(ReadMesh, ListsTheFilesThatAMeshRefersTo) {
  const support::GltfAndBin parts = as_gltf(road_, "a.bin");
  const std::string bin = folder_.file("a.bin", parts.bin);
  MeshReadReport report;
  EXPECT_LT(distance(road_, road::read_mesh(folder_.file("a.gltf", parts.gltf), {}, &report)),
            2e-5);
  ASSERT_EQ(report.files.size(), 1u);
  EXPECT_EQ(report.files[0].path, bin);
  EXPECT_EQ(report.files[0].sha256, base::sha256(parts.bin));
  EXPECT_TRUE(report.remarks.empty());

  const std::string materials = "newmtl asphalt\nnewmtl concrete\n";
  const std::string mtl = folder_.file("road.mtl", materials);
  const std::string obj = folder_.file("a.obj", "mtllib road.mtl\n" + as_obj(road_));
  road::read_mesh(obj, {}, &report);
  ASSERT_EQ(report.files.size(), 1u);
  EXPECT_EQ(report.files[0].path, mtl);
  EXPECT_EQ(report.files[0].sha256, base::sha256(materials));
  EXPECT_TRUE(report.remarks.empty());

  std::filesystem::remove(mtl);
  road::read_mesh(obj, {}, &report);
  ASSERT_GE(report.files.size(), 2u);  // assimp looks in other places as well
  EXPECT_EQ(report.files[0].path, mtl);
  EXPECT_EQ(report.files[0].sha256, "");
  ASSERT_EQ(report.remarks.size(), 1u);
  EXPECT_THAT(report.remarks[0], HasSubstr("missing: " + mtl + ";"));

  road::read_mesh(folder_.file("a.stl", as_stl(road_)), {}, &report);
  EXPECT_TRUE(report.files.empty());
}

TEST_F(ReadMesh, CutsPolygonsIntoTrianglesInsideThem) {
  // An L of 300 m2 + 100 m2 as one face, from either side; the fan from its first corner would
  // leave it.
  MeshReadOptions options;
  options.up = road::UpAxis::z;
  for (const char* face : {"f 3 4 5 6 1 2\n", "f 2 1 6 5 4 3\n"}) {
    const Mesh mesh = road::read_mesh(
        folder_.file(
            "l.obj",
            std::string("v 0 0 0\nv 30 0 0\nv 30 10 0\nv 10 10 0\nv 10 20 0\nv 0 20 0\n") + face),
        options);
    double area = 0.0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      area += 0.5 * (mesh.vertex(i, 1) - mesh.vertex(i, 0))
                        .cross(mesh.vertex(i, 2) - mesh.vertex(i, 0))
                        .norm();
    }
    EXPECT_EQ(mesh.triangles.size(), 4u);
    EXPECT_NEAR(area, 400.0, 1e-3);
  }
}

TEST_F(ReadMesh, RefusesAnAxisThatTheFacesContradict) {
  MeshReadOptions options;
  options.up = road::UpAxis::y;
  EXPECT_THAT(message_of(folder_.file("z.obj", as_obj(road_, 'z')), options),
              HasSubstr("give --up z"));
  options.up = road::UpAxis::z;
  EXPECT_THAT(message_of(folder_.file("y.obj", as_obj(road_, 'y')), options),
              HasSubstr("give --up y"));
  EXPECT_EQ(message_of(folder_.file("z.obj", as_obj(road_, 'z')), options), "no error");
}

TEST_F(ReadMesh, FollowsTheFacesAgainstTheFormatAndSaysSo) {
  Mesh lying = road_;  // an .acc with z up inside
  for (auto& v : lying.vertices_m) v = Eigen::Vector3d(v.x(), -v.z(), v.y());
  MeshReadReport report;
  const Mesh seen = road::read_mesh(folder_.file("a.acc", as_acc(lying)), {}, &report);
  EXPECT_EQ(report.up, "z");
  EXPECT_LT(distance(road_, seen), 2e-5);
  EXPECT_THAT(report.remarks, ::testing::Contains(HasSubstr("the large flat faces say z")));
}

TEST_F(ReadMesh, AsksForTheAxisWhenItCannotTell) {
  // A cube: as much face along every axis.
  const std::string cube =
      "v 0 0 0\nv 20 0 0\nv 20 20 0\nv 0 20 0\nv 0 0 20\nv 20 0 20\nv 20 20 20\nv 0 20 20\n"
      "f 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
  EXPECT_THAT(message_of(folder_.file("cube.obj", cube)), HasSubstr("give --up y or --up z"));
}

/// A square of 20 m of road in 100 pieces, corners 1 to 4 last, and four walls round it, all facing
/// inwards: those of `faces`, corners 5 to 8 above 1 to 4.
std::string square_between_walls(double height, const char* faces) {
  std::string text = "v 0 0 0\nv 20 0 0\nv 20 20 0\nv 0 20 0\n";
  for (const char* corner : {"0 0", "20 0", "20 20", "0 20"})
    text += fmt::format("v {} {}\n", corner, height);
  for (int i = 0; i < 100; ++i) {
    const int x = 2 * (i % 10), y = 2 * (i / 10);
    text += fmt::format("v {0} {1} 0\nv {2} {1} 0\nv {2} {3} 0\nv {0} {3} 0\nf -4 -3 -2 -1\n", x, y,
                        x + 2, y + 2);
  }
  return text + faces;
}

TEST_F(ReadMesh, TellsTheAxisOfARoadBetweenHighWalls) {
  // The walls have more area than the road; all round they cancel out.
  const char* all = "f 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n";
  MeshReadReport report;
  for (const double height : {12.0, 18.0}) {
    road::read_mesh(folder_.file("walls.obj", square_between_walls(height, all)), {}, &report);
    EXPECT_EQ(report.up, "z") << height;
  }
  EXPECT_THAT(message_of(folder_.file("walls.obj", square_between_walls(22.0, all))),
              HasSubstr("cannot tell which axis is up"))
      << "walls alone say y, what is left says z";
  std::string large = square_between_walls(22.0, all);  // a road of two facets contradicts as well
  large = large.substr(0, large.find("v 0 0 0", 1)) + "f 1 2 3 4\n" + all;
  EXPECT_THAT(message_of(folder_.file("large.obj", large)),
              HasSubstr("cannot tell which axis is up"));
  MeshReadOptions told;
  told.up = road::UpAxis::z;
  EXPECT_EQ(message_of(folder_.file("walls.obj", square_between_walls(22.0, all)), told),
            "no error");
  EXPECT_THAT(message_of(folder_.file("wall.obj", square_between_walls(18.0, "f 1 5 6 2\n"))),
              HasSubstr("47 % is left along y and 53 % along z"))
      << "a backdrop does not cancel out";
}

TEST_F(ReadMesh, ScalesUnitsAndRefusesMillimetresTakenForMetres) {
  for (const auto& [unit, name, scale] : {std::tuple{road::Unit::mm, "mm", 1000.0},
                                          {road::Unit::cm, "cm", 100.0},
                                          {road::Unit::ft, "ft", 1.0 / 0.3048},
                                          {road::Unit::inch, "inch", 1.0 / 0.0254},
                                          {road::Unit::yard, "yard", 1.0 / 0.9144},
                                          {road::Unit::m, "m", 1.0}}) {
    MeshReadOptions options;
    options.unit = unit;
    MeshReadReport report;
    const Mesh seen = road::read_mesh(
        folder_.file("scaled.obj", as_obj(road_, 'z', Eigen::Vector3d::Zero(), scale)), options,
        &report);
    EXPECT_LT(distance(road_, seen), 5e-5) << name;  // float32 of 200,000 mm: 16 um
    EXPECT_EQ(report.unit, name);
  }
  MeshReadOptions scaled;
  for (const auto& [unit, name, factor] : {std::tuple{road::Unit::automatic, "m", 0.254},
                                           {road::Unit::cm, "cm", 25.4},
                                           {road::Unit::cm, "cm", 0.5}}) {
    scaled.unit = unit;
    scaled.scale = factor;
    const double per_metre = 1.0 / (factor * road::metres_per(unit));
    MeshReadReport report;
    const Mesh seen = road::read_mesh(
        folder_.file("scaled.obj", as_obj(road_, 'z', Eigen::Vector3d::Zero(), per_metre)), scaled,
        &report);
    EXPECT_LT(distance(road_, seen), 5e-5) << factor;
    EXPECT_EQ(report.unit, name);
    EXPECT_EQ(report.scale, factor);
  }
  scaled.scale = 1e-3;
  EXPECT_THAT(message_of(folder_.file("m.obj", as_obj(road_)), scaled),
              HasSubstr("times the scale 0.001"));
  const std::string mm =
      folder_.file("mm.obj", as_obj(road_, 'z', Eigen::Vector3d::Zero(), 1000.0));
  EXPECT_THAT(message_of(mm), HasSubstr("200000 m across"));
  EXPECT_THAT(message_of(mm),
              HasSubstr("--unit cm (2000 m) or --unit mm (200 m) or --unit inch (5080 m)"));
  MeshReadOptions wrong;
  wrong.unit = road::Unit::mm;
  EXPECT_THAT(message_of(folder_.file("m.obj", as_obj(road_)), wrong),
              HasSubstr("wanted 3 m to 40 km"));
}

TEST_F(ReadMesh, KeepsMillimetresAtUtmCoordinatesOfTextAndDoubles) {
  const Eigen::Vector3d utm(455'123.25, 5'300'456.5, 312.0);
  for (const auto& [name, bytes] : std::vector<std::pair<std::string, std::string>>{
           {"z.obj", as_obj(road_, 'z', utm)},
           {"y.obj", as_obj(road_, 'y', utm)},
           {"a.acc", as_acc(road_, utm)},
           {"a.ply", as_ply(road_, "ascii", "double", utm)},
           {"b.ply", as_ply(road_, "binary_little_endian", "double", utm)}}) {
    MeshReadReport report;
    const Mesh seen = road::read_mesh(folder_.file(name, bytes), {}, &report);
    EXPECT_LT(distance(road_, seen, utm), 2e-5) << name;
    EXPECT_LT(seen.vertices_m.front().norm(), 1000.0)
        << name << ": vertices stay near the local origin";
    EXPECT_LT(report.coordinate_resolution_m, 1e-6) << name;
  }
}

TEST_F(ReadMesh, RefusesUtmCoordinatesThatFloat32Destroyed) {
  const std::string far =
      message_of(folder_.file("far.stl", as_stl(road_, {455'123.0, 5'300'456.0, 0.0})));
  EXPECT_THAT(far, HasSubstr("snap to 0.5 m"));
  EXPECT_THAT(far, HasSubstr("subtract ("));
  EXPECT_THAT(message_of(folder_.file("far.ply", as_ply(road_, "binary_little_endian", "float",
                                                        {455'123.0, 5'300'456.0, 0.0}))),
              HasSubstr("snap to 0.5 m"));
  // Text written from float32 numbers is no better.
  Mesh snapped;
  snapped.objects = road_.objects;
  for (int copy = 0; copy < 3; ++copy) {
    for (std::size_t i = 0; i < road_.triangles.size(); ++i) {
      const auto base = static_cast<std::uint32_t>(snapped.vertices_m.size());
      for (int c = 0; c < 3; ++c) {
        Eigen::Vector3d v =
            road_.vertex(i, c) +
            Eigen::Vector3d(455'123.0 + 0.123 * static_cast<double>(i),
                            5'300'456.0 + 30.7 * copy + 0.377 * static_cast<double>(i), 0.0);
        // volatile: gcc 12 vectorises double -> float -> double away at -O2.
        for (double& value : v) {
          volatile float single = static_cast<float>(value);
          value = static_cast<double>(single);
        }
        snapped.vertices_m.push_back(v);
      }
      snapped.triangles.push_back({base, base + 1, base + 2});
      snapped.object_of_triangle.push_back(0);
    }
  }
  EXPECT_THAT(message_of(folder_.file("far.obj", as_obj(snapped))), HasSubstr("snap to 0.5 m"));
  // Kilometres away is fine but worth a remark.
  MeshReadReport report;
  road::read_mesh(folder_.file("near.stl", as_stl(road_, {40'000.0, 20'000.0, 0.0})), {}, &report);
  EXPECT_NEAR(report.coordinate_resolution_m, 0.0039, 0.0001);
  EXPECT_THAT(report.remarks, ::testing::Contains(HasSubstr("snap to 3.9 mm")));
}

TEST_F(ReadMesh, NamesThePlaceOfUnusableCoordinates) {
  std::string obj = as_obj(road_);
  obj.replace(obj.find("v 10.000000"), 11, "v nan");
  EXPECT_THAT(message_of(folder_.file("nan.obj", obj)),
              HasSubstr("nan.obj:4: a coordinate is nan"));
  std::string acc = as_acc(road_);
  acc.replace(acc.find("10.000000 "), 10, "1e30 ");
  EXPECT_THAT(message_of(folder_.file("far.acc", acc)), HasSubstr("a coordinate is 1e+30"));
  // assimp leaves memory unset for a surface without corners.
  for (const char* bare : {"SURF 0x1\n", "SURF 0x1\nmat 0\nrefs 0\n"}) {
    acc = as_acc(road_);
    acc.insert(acc.find("SURF"), bare);
    EXPECT_THAT(message_of(folder_.file("bare.acc", acc)),
                testing::AnyOf(HasSubstr("wanted 'refs COUNT' of the surface before it"),
                               HasSubstr("wanted a surface of at least one corner")));
  }
  Mesh broken = road_;
  broken.vertices_m[4].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message_of(folder_.file("nan.stl", as_stl(broken))),
              HasSubstr("vertex 5: (10, nan, 0.2"));
  broken.vertices_m[4].y() = 1e30;
  EXPECT_THAT(message_of(folder_.file("far.ply", as_ply(broken, "binary_little_endian", "double"))),
              HasSubstr("1e+30"));
  EXPECT_THAT(message_of(folder_.file("far.glb", as_glb(broken))), HasSubstr("object 'road'"));
}

TEST_F(ReadMesh, RefusesMissingEmptyAndForeignFiles) {
  EXPECT_THAT(message_of(folder_.path("missing.obj")), HasSubstr("No such file"));
  EXPECT_THAT(message_of(folder_.path("")), HasSubstr("is a folder"));
  for (const char* extension :
       {"obj", "acc", "ac", "stl", "ply", "glb", "gltf", "fbx", "dae", "3ds", "txt"}) {
    const std::string name = std::string("a.") + extension;
    EXPECT_THAT(message_of(folder_.file(name, "")), HasSubstr("the file is empty")) << extension;
    EXPECT_THAT(message_of(folder_.file(
                    name, "version https://git-lfs.github.com/spec/v1\noid sha256:77\nsize 9\n")),
                HasSubstr(name + ": is a pointer of Git LFS"))
        << extension;
    EXPECT_THAT(message_of(folder_.file(name, "\n<!DOCTYPE html>\n<html><body>404</body></html>")),
                HasSubstr(name + ": is an HTML page"))
        << extension;
    EXPECT_NE(message_of(folder_.file(name, "Dear editor,\nthis is a letter and no mesh.\n")),
              "no error")
        << extension;
    EXPECT_NE(
        message_of(folder_.file(name, std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\1\0", 20) +
                                          std::string(200, '\7'))),
        "no error")
        << extension;
  }
  EXPECT_THAT(message_of(folder_.file("points.obj", "v 0 0 0\nv 100 0 0\nv 0 100 0\n")),
              HasSubstr("no faces"));
}

TEST_F(ReadMesh, NoticesTruncationAnywhere) {
  for (const auto& [name, bytes] : std::vector<std::pair<std::string, std::string>>{
           {"a.stl", as_stl(road_)},
           {"b.stl", as_text_stl(road_)},
           {"c.ply", as_ply(road_, "binary_little_endian", "double")},
           {"d.ply", as_ply(road_, "ascii", "float")},
           {"e.acc", as_acc(road_)},
           {"f.glb", as_glb(road_)}}) {
    // The last byte of a text is its line end, which may be missing; cuts inside the last number of
    // a text and exactly between two objects of an .acc cannot be told from a shorter mesh.
    for (int k = 1; k < 40; ++k) {
      const std::size_t length = bytes.size() * static_cast<std::size_t>(k) / 41;
      EXPECT_NE(message_of(folder_.file(name, bytes.substr(0, length))), "no error")
          << name << " cut at " << length << " of " << bytes.size();
    }
  }
  EXPECT_THAT(message_of(folder_.file("a.stl", as_stl(road_).substr(0, 1000))),
              HasSubstr("the file is truncated: its header promises 80 triangles"));
}

TEST_F(ReadMesh, BoundsWhatForgedFilesAskFor) {
  // Each would need terabytes, or a deep stack, if its numbers were believed.
  std::string stl = as_stl(road_);
  const std::uint32_t many = 4'000'000'000u;
  std::memcpy(stl.data() + 80, &many, 4);
  EXPECT_THAT(message_of(folder_.file("a.stl", stl)), HasSubstr("truncated"));
  std::string ply = as_ply(road_, "binary_little_endian", "double");
  ply.replace(ply.find("vertex 63"), 9, "vertex 63000000000000");
  EXPECT_THAT(message_of(folder_.file("a.ply", ply)), HasSubstr("truncated or damaged"));
  std::string list =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\nelement face 1\n"
      "property list uint int vertex_indices\nend_header\n0 0 0\n100 0 0\n0 100 0\n4000000000 0 1 "
      "2\n";
  EXPECT_THAT(message_of(folder_.file("b.ply", list)), HasSubstr("truncated or damaged"));
  std::string acc = as_acc(road_);
  acc.replace(acc.find("numvert 63"), 10, "numvert 99999999999999");
  EXPECT_NE(message_of(folder_.file("a.acc", acc)), "no error");
  std::string nested = "AC3Db\n";
  for (int i = 0; i < 200'000; ++i) nested += "OBJECT group\nkids 1\n";
  EXPECT_THAT(message_of(folder_.file("b.acc", nested)), HasSubstr("nested less than 256 deep"));
  std::string index = as_acc(road_);
  index.replace(index.find("refs 3\n0 "), 9, "refs 3\n77777 ");
  EXPECT_THAT(message_of(folder_.file("c.acc", index)),
              HasSubstr("one of the object's 63 vertices"));
  std::string face = as_obj(road_);
  face.replace(face.find("f 1 "), 4, "f 100000 ");
  EXPECT_NE(message_of(folder_.file("a.obj", face)), "no error");
}

TEST_F(ReadMesh, WritesWhatItReads) {
  Mesh mesh = road_;
  mesh.origin_m = {455'000.0, 5'300'000.0, 300.0};
  for (const char* name : {"a.ply", "a.obj"}) {
    road::write_mesh(mesh, folder_.path(name));
    EXPECT_LT(distance(mesh, road::read_mesh(folder_.path(name))), 2e-5) << name;
    const std::string first = folder_.read(name);
    road::write_mesh(mesh, folder_.path(name));
    EXPECT_EQ(folder_.read(name), first) << name;
  }
  mesh.origin_m = {1000.0, 2000.0, 0.0};
  road::write_mesh(mesh, folder_.path("a.stl"));
  EXPECT_LT(distance(mesh, road::read_mesh(folder_.path("a.stl"))),
            2e-4);  // float32 of 2,000 m: 0.12 mm
  EXPECT_EQ(folder_.read("a.stl").size(), 84 + 50 * mesh.triangles.size());
  try {
    road::write_mesh(mesh, folder_.path("a.xyz"));
    FAIL();
  } catch (const road::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr(".stl, .ply or .obj"));
  }
}

TEST(ReadMeshOpen, NamesAPointerOfGitLfs) {
  const std::string path = places::data() + "/meshes2/nfsput_spielberg_lfs.glb";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent";
  EXPECT_THAT(message_of(path), HasSubstr("git lfs pull"));
}

TEST(ReadMeshTorcs, ReadsEveryTrack) {
  const std::filesystem::path tracks = places::torcs_tracks();
  if (!std::filesystem::exists(tracks)) GTEST_SKIP() << tracks << " is not installed";
  std::size_t read = 0;
  for (const char* kind : {"road", "oval", "dirt"}) {
    for (const auto& folder : std::filesystem::directory_iterator(tracks / kind)) {
      for (const char* extension : {".acc", ".ac"}) {
        const auto path = folder.path() / (folder.path().filename().string() + extension);
        if (!std::filesystem::exists(path)) continue;
        MeshReadReport report;
        const Mesh mesh = road::read_mesh(path.string(), {}, &report);
        ++read;
        EXPECT_EQ(report.up, "y") << path;
        EXPECT_GT(mesh.triangles.size(), 4000u) << path;
        std::size_t named = 0, textured = 0;
        for (const auto& object : mesh.objects) {
          named += !object.name.empty();
          textured += object.texture.find('.') != std::string::npos;
          EXPECT_EQ(object.texture.find("empty_texture"), std::string::npos)
              << path << " " << object.name;
        }
        EXPECT_EQ(named, mesh.objects.size()) << path;
        // A few scenery objects have no texture at all.
        EXPECT_GT(textured, mesh.objects.size() * 95 / 100) << path;
      }
    }
  }
  EXPECT_EQ(read, 38u);
}

}  // namespace read_mesh_test
