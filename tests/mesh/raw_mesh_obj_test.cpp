// Objects, groups and materials of .obj files that come and go and come again.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "mesh/error.h"
#include "mesh/read_mesh.h"
#include "support/temporary_folder.h"

namespace raw_mesh_obj_test {

using ::testing::HasSubstr;

/// What the writer below knows of an object and material without having read anything.
struct Share {
  std::size_t triangles = 0;
  double area_m2 = 0.0;
};
using Shares = std::map<std::pair<std::string, std::string>, Share>;

/// Writes rectangles on the ground one after the other, each with vertices of its own.
class ObjWriter {
 public:
  enum class Index { absolute, relative, with_texture, relative_with_normal };

  void object(const std::string& name) { line("o " + name), object_ = name; }
  void group(const std::string& name) { line("g " + name), object_ = name; }
  void material(const std::string& name) { line("usemtl " + name), material_ = name; }
  void line(const std::string& text) { text_ += text + '\n'; }
  void rectangles(int count, Index index = Index::absolute) {
    for (int i = 0; i < count; ++i) {
      const double x = 10.0 * (number_ % 20), y = 10.0 * (number_ / 20), side = 1.0 + number_ % 7;
      ++number_;
      line(fmt::format("v {0} {1} 0\nv {2} {1} 0\nv {2} {3} 0\nv {0} {3} 0", x, y, x + side,
                       y + side));
      const int last = 4 * number_;
      std::string corners;
      for (int c = 1; c <= 4; ++c) {
        switch (index) {
          case Index::absolute:
            corners += fmt::format(" {}", last - 4 + c);
            break;
          case Index::relative:
            corners += fmt::format(" {}", c - 5);
            break;
          case Index::with_texture:
            corners += fmt::format(" {}/1", last - 4 + c);
            break;
          case Index::relative_with_normal:
            corners += fmt::format(" {}//-1", c - 5);
            break;
        }
      }
      line("f" + corners);
      Share& share = shares_[{object_, material_}];
      share.triangles += 2;
      share.area_m2 += side * side;
    }
  }
  const std::string& text() const { return text_; }
  const Shares& shares() const { return shares_; }

 private:
  std::string text_ = "vt 0 0\nvn 0 0 1\n", object_, material_;
  int number_ = 0;
  Shares shares_;
};

Shares shares_of(const road::Mesh& mesh) {
  Shares shares;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const road::MeshObject& object = mesh.objects[mesh.object_of_triangle[i]];
    Share& share = shares[{object.name, object.material}];
    ++share.triangles;
    share.area_m2 +=
        0.5 *
        (mesh.vertex(i, 1) - mesh.vertex(i, 0)).cross(mesh.vertex(i, 2) - mesh.vertex(i, 0)).norm();
  }
  return shares;
}

void expect_read(const ObjWriter& writer, const std::string& what) {
  const support::TemporaryFolder folder;
  const Shares seen = shares_of(road::read_mesh(folder.file("a.obj", writer.text())));
  EXPECT_EQ(seen.size(), writer.shares().size()) << what;
  for (const auto& [names, wanted] : writer.shares()) {
    const auto found = seen.find(names);
    ASSERT_NE(found, seen.end()) << what << ": " << names.first << "|" << names.second;
    EXPECT_EQ(found->second.triangles, wanted.triangles)
        << what << ": " << names.first << "|" << names.second;
    EXPECT_NEAR(found->second.area_m2, wanted.area_m2, 1e-6 * wanted.area_m2)
        << what << ": " << names.first << "|" << names.second;
  }
}

TEST(ReadObj, KeepsTheTrianglesOfAnObjectThatComesTwice) {
  ObjWriter writer;
  for (const auto& [object, material, count] : {std::tuple{"road", "asphalt", 30},
                                                {"deck", "concrete", 13},
                                                {"road", "asphalt", 20},
                                                {"deck", "steel", 2},
                                                {"deck", "concrete", 1},
                                                {"road", "concrete", 5}}) {
    writer.object(object);
    writer.material(material);
    writer.rectangles(count);
  }
  expect_read(writer, "objects");
}

TEST(ReadObj, KeepsTheTrianglesOfAGroupThatComesTwice) {
  ObjWriter writer;
  writer.material("asphalt");  // stays in force over the groups that follow
  writer.group("road");
  writer.rectangles(10);
  writer.group("deck left");  // two names, taken as one
  writer.rectangles(4);
  writer.group("road");
  writer.rectangles(3);
  writer.group("deck right");
  writer.material("concrete");
  writer.rectangles(2);
  writer.group("deck left");
  writer.rectangles(5);
  writer.object("road");  // the last of o and g says the name
  writer.rectangles(1);
  expect_read(writer, "groups");
}

TEST(ReadObj, FollowsMaterialsToAndFro) {
  ObjWriter writer;
  writer.rectangles(2);  // before any name
  writer.object("road");
  for (int i = 0; i < 5; ++i) {
    writer.material("asphalt");
    writer.material("asphalt");
    writer.rectangles(3);
    writer.material("paint");
    writer.rectangles(1 + i);
    writer.material("kerb");  // no face of it
  }
  writer.object("empty");
  writer.object("old town bridge");
  writer.rectangles(2);
  writer.object("old town hall");
  writer.rectangles(2);
  expect_read(writer, "materials");
}

TEST(ReadObj, TakesIndicesThatCountFromTheEnd) {
  ObjWriter writer;
  using Index = ObjWriter::Index;
  for (const Index index : {Index::relative, Index::with_texture, Index::relative_with_normal,
                            Index::absolute, Index::relative}) {
    writer.object(index == Index::absolute ? "road" : "deck");
    writer.rectangles(4, index);
  }
  writer.line("f 1 2 \\\n 3");  // one line to the readers of such files
  ObjWriter continued = writer;
  const support::TemporaryFolder folder;
  const Shares seen = shares_of(road::read_mesh(folder.file("a.obj", continued.text())));
  EXPECT_EQ(seen.at({"deck", ""}).triangles, writer.shares().at({"deck", ""}).triangles + 1);
  EXPECT_EQ(seen.at({"road", ""}).triangles, writer.shares().at({"road", ""}).triangles);
}

TEST(ReadObj, KeepsEveryTriangleOfAnyOrder) {
  for (unsigned int seed = 0; seed < 30; ++seed) {
    std::mt19937 generator(seed);
    ObjWriter writer;
    for (int i = 0; i < 60; ++i) {
      const std::string name(1, static_cast<char>('a' + generator() % 5));
      switch (generator() % 4) {
        case 0:
          writer.object(name);
          break;
        case 1:
          writer.group(name);
          break;
        case 2:
          writer.material("m" + name);
          break;
        default:
          writer.rectangles(1 + static_cast<int>(generator() % 3),
                            static_cast<ObjWriter::Index>(generator() % 4));
      }
    }
    writer.rectangles(1);
    expect_read(writer, fmt::format("seed {}", seed));
  }
}

TEST(ReadObj, TrianglesAndPolygonsStandInTheOrderOfTheFile) {
  const support::TemporaryFolder folder;
  std::string text;
  // Each face along x has one corner more than the one before; every second one is a triangle.
  for (int face = 0; face < 12; ++face) {
    const int corners = face % 2 == 0 ? 3 : 4 + face / 2;
    for (int k = 0; k < corners; ++k) {
      const double angle = 2.0 * M_PI * k / corners;
      text += fmt::format("v {} {} 0\n", 10.0 * face + std::cos(angle), std::sin(angle));
    }
    text += fmt::format("o {}\nf", face % 3);
    for (int k = corners; k > 0; --k) text += fmt::format(" -{}", k);
    text += '\n';
  }
  const road::Mesh mesh = road::read_mesh(folder.file("a.obj", text));
  std::vector<int> faces;  // of each triangle, told by where it lies
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double x = (mesh.vertex(t, 0) + mesh.vertex(t, 1) + mesh.vertex(t, 2)).x() / 3.0;
    const int face = static_cast<int>(std::lround((x + mesh.origin_m.x()) / 10.0));
    EXPECT_EQ(mesh.objects[mesh.object_of_triangle[t]].name, fmt::to_string(face % 3)) << t;
    faces.push_back(face);
  }
  EXPECT_TRUE(std::is_sorted(faces.begin(), faces.end()));
  EXPECT_EQ(std::count(faces.begin(), faces.end(), 4), 1);
  EXPECT_EQ(std::count(faces.begin(), faces.end(), 5), 4);
}

TEST(ReadObj, RefusesFacesThatWouldTakeMinutesToCut) {
  const support::TemporaryFolder folder;
  constexpr int kCorners = 2000;
  std::string vertices, face = "f";
  for (int k = 0; k < kCorners; ++k) {
    const double angle = 2.0 * M_PI * k / kCorners;
    vertices += fmt::format("v {} {} 0\n", 100.0 * std::cos(angle), 100.0 * std::sin(angle));
    face += fmt::format(" {}", k + 1);
  }
  std::string few = vertices, many = vertices;
  for (int k = 0; k < 100; ++k) (k < 3 ? few : many) += face + '\n';
  EXPECT_EQ(road::read_mesh(folder.file("few.obj", few)).triangles.size(), 3u * (kCorners - 2));
  try {
    road::read_mesh(folder.file("many.obj", many));
    ADD_FAILURE() << "read";
  } catch (const road::Error& error) {
    EXPECT_THAT(error.what(), testing::AllOf(HasSubstr("many.obj: cutting its faces"),
                                             HasSubstr("export it again")));
  }
}

TEST(ReadObj, KeepsWhatTextCanCarry) {
  // 1/3 of a micrometre at 900 m is beyond float32 (30 um).
  const support::TemporaryFolder folder;
  const road::Mesh mesh = road::read_mesh(
      folder.file("a.obj", "v 900.0000003 0 0\nv 910 0 0\nv 910 10.0000007 0\nf 1 2 3\n"));
  EXPECT_DOUBLE_EQ(mesh.vertex(0, 0).x() + mesh.origin_m.x(), 900.0000003);
  EXPECT_DOUBLE_EQ(mesh.vertex(0, 2).y() + mesh.origin_m.y(), 10.0000007);
}

TEST(ReadObj, ReadsTheTextureBehindItsOptions) {
  const support::TemporaryFolder folder;
  folder.file("a.mtl",
              "newmtl one\nmap_Kd -s 2 2 1 -clamp on -mm 0 1 textures\\one.png\n"
              "newmtl two\r\nMAP_KD textures/second one.png  \r\nnewmtl three\nmap_Kd\n"
              "newmtl four\nmap_Bump bump.png\nmap_Kd -blendu off 4.png\n");
  std::string text = "mtllib a.mtl\nmtllib a.mtl\nv 0 0 0\nv 10 0 0\nv 0 10 0\n";
  for (const char* name : {"one", "two", "three", "four", "five"})
    text += fmt::format("usemtl {}\nf 1 2 3\n", name);
  road::MeshReadReport report;
  const road::Mesh mesh = road::read_mesh(folder.file("b.obj", text), {}, &report);
  std::vector<std::string> textures;
  for (const auto& object : mesh.objects)
    textures.push_back(object.material + ":" + object.texture);
  EXPECT_THAT(textures, testing::ElementsAre("one:one.png", "two:second one.png",
                                             "three:", "four:4.png", "five:"));
  EXPECT_EQ(report.files.size(), 1u);
  // A list that is missing is looked for under the name of the mesh.
  folder.file("c.mtl", "newmtl one\nmap_Kd other.png\n");
  text.replace(0, 25, "mtllib gone.mtl\n");
  EXPECT_EQ(road::read_mesh(folder.file("c.obj", text), {}, &report).objects[0].texture,
            "other.png");
  EXPECT_THAT(report.remarks, testing::ElementsAre(HasSubstr("gone.mtl")));
}

TEST(ReadObj, NamesTheLineOfAFaceThatCannotBe) {
  const support::TemporaryFolder folder;
  const std::string vertices = "v 0 0 0\nv 10 0 0\nv 0 10 0\n";
  for (const auto& [face, place] : {std::pair{"f 1 2 4", "a.obj:4: a face has corner 4"},
                                    {"f 1 2 -4", "a.obj:4: 'f 1 2 -4'"},
                                    {"f 0 1 2", "a.obj:4: 'f 0 1 2'"},
                                    {"f 1 2 x", "a.obj:4: 'f 1 2 x'"},
                                    {"f 1 2 99999999999999999999", "a.obj:4: 'f 1 2 9"}}) {
    try {
      road::read_mesh(folder.file("a.obj", vertices + face + "\nf 1 2 3\n"));
      ADD_FAILURE() << face;
    } catch (const road::Error& error) {
      EXPECT_THAT(error.what(),
                  testing::AllOf(HasSubstr(place), HasSubstr("export the mesh again")));
    }
  }
  // A face may stand before its vertices.
  EXPECT_EQ(road::read_mesh(folder.file("b.obj", "f 1 2 3\n" + vertices)).triangles.size(), 1u);
}

}  // namespace raw_mesh_obj_test
