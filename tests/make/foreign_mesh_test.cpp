// Meshes that refer to other files, are nested beyond reason or crash their reader.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <cstring>
#include <filesystem>

#include "mesh/error.h"
#include "mesh/read_mesh.h"
#include "support/mesh_files.h"
#include "support/temporary_folder.h"

namespace foreign_mesh_test {

namespace fs = std::filesystem;
using road::Mesh;
using road::MeshReadOptions;
using road::MeshReadReport;
using ::testing::HasSubstr;
using ::testing::Not;

class ForeignMesh : public ::testing::Test {
 protected:
  ForeignMesh() { fs::create_directories(folder_.path("track")); }

  std::string gltf(const std::string& uri) const {
    return folder_.file("track/a.gltf", support::as_gltf(support::small_road(), uri).gltf);
  }
  std::string obj(const std::string& library) const {
    return folder_.file("track/a.obj",
                        "mtllib " + library + "\n" + support::as_obj(support::small_road()));
  }
  std::string bin(const std::string& name) const {
    return folder_.file(name, support::as_gltf(support::small_road(), "").bin);
  }

  support::TemporaryFolder folder_;
};

std::string message_of(const std::string& path, const MeshReadOptions& options = {}) {
  try {
    road::read_mesh(path, options);
  } catch (const road::Error& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return error.what();
  }
  return "no error";
}

TEST_F(ForeignMesh, ReadsBuffersBelowItsFolderOnly) {
  bin("a.bin");
  const std::string absolute = bin("elsewhere.bin");
  MeshReadOptions outside;
  outside.allow_outside = true;
  // assimp takes strokes of other systems for those of this one where a file is not found as it
  // stands.
  for (const std::string uri : {"../a.bin", "../track/../a.bin", "..\\\\a.bin"}) {
    EXPECT_THAT(message_of(gltf(uri)),
                testing::AllOf(HasSubstr("lies outside the folder of the mesh"),
                               HasSubstr("--allow-outside")))
        << uri;
    EXPECT_EQ(message_of(gltf(uri), outside), "no error") << uri;
  }
  for (const std::string& uri :
       {absolute, "file://" + absolute, std::string("..%2fa.bin"), std::string("%2e%2e/a.bin")})
    EXPECT_NE(message_of(gltf(uri)), "no error") << uri;

  // Without a folder in its own path, the URI is all that assimp opens.
  const fs::path before = fs::current_path();
  const std::string name = fs::path(gltf(absolute)).filename();
  fs::current_path(folder_.path("track"));
  EXPECT_THAT(message_of(name),
              HasSubstr("'" + absolute + "' lies outside the folder of the mesh"));
  EXPECT_EQ(message_of(name, outside), "no error");
  gltf("missing.bin");  // beside the mesh, though it is not there
  EXPECT_THAT(message_of(name), testing::Not(HasSubstr("outside")));
  MeshReadReport report;
  obj("missing.mtl");
  road::read_mesh("a.obj", {}, &report);
  EXPECT_THAT(report.remarks,
              testing::ElementsAre(HasSubstr("files that are missing: missing.mtl;")));
  fs::current_path(before);

  fs::create_symlink(folder_.path("a.bin"), folder_.path("track/link.bin"));
  EXPECT_THAT(message_of(gltf("link.bin")), HasSubstr("link.bin' lies outside"));
  fs::create_directories(folder_.path("track/data"));
  bin("track/data/b.bin");
  fs::create_symlink("data", folder_.path("track/here"));
  for (const std::string uri :
       {"data/b.bin", "here/b.bin", "data/../data/b.bin", "../track/data/b.bin"})
    EXPECT_EQ(message_of(gltf(uri)), "no error") << uri;
}

TEST_F(ForeignMesh, ReadsMaterialsBelowItsFolderOnly) {
  folder_.file("road.mtl", "newmtl asphalt\nmap_Kd new_asphalt.png\nnewmtl concrete\n");
  const fs::path before = fs::current_path();
  for (const std::string& library : {std::string("../road.mtl"), folder_.path("road.mtl")}) {
    MeshReadOptions options;
    MeshReadReport report;
    fs::current_path(folder_.path("track"));
    obj(library);
    Mesh mesh = road::read_mesh("a.obj", options, &report);
    EXPECT_EQ(mesh.objects[mesh.object_of_triangle[0]].texture, "");
    ASSERT_EQ(report.remarks.size(), 1u);
    EXPECT_THAT(report.remarks[0],
                testing::AllOf(HasSubstr("road.mtl' lies outside the folder of the mesh"),
                               HasSubstr("--allow-outside")));
    options.allow_outside = true;
    mesh = road::read_mesh("a.obj", options, &report);
    EXPECT_EQ(mesh.objects[mesh.object_of_triangle[0]].texture, "new_asphalt.png");
    EXPECT_TRUE(report.remarks.empty());
    fs::current_path(before);
  }
}

TEST_F(ForeignMesh, IsTheSameByAPathThatGoesUp) {
  obj("missing.mtl");
  fs::create_directories(folder_.path("other"));
  MeshReadReport report;
  const Mesh mesh = road::read_mesh(folder_.path("other/../track/a.obj"), {}, &report);
  EXPECT_FALSE(mesh.triangles.empty());
  ASSERT_EQ(report.remarks.size(), 1u);
  EXPECT_THAT(report.remarks[0],
              testing::AllOf(HasSubstr("missing.mtl"), Not(HasSubstr("outside"))));
}

TEST_F(ForeignMesh, WaitsForNoFifo) {
  for (const char* name : {"track/a.bin", "track/a.mtl", "track/b.mtl", "fifo.obj", "fifo.glb",
                           "fifo.stl", "fifo.ply", "fifo.acc"})
    ASSERT_EQ(::mkfifo(folder_.path(name).c_str(), 0600), 0);
  EXPECT_THAT(message_of(gltf("a.bin")), HasSubstr("wanted a regular file"));
  for (const char* name : {"fifo.obj", "fifo.glb", "fifo.stl", "fifo.ply", "fifo.acc"})
    EXPECT_THAT(message_of(folder_.path(name)), HasSubstr("wanted a regular file"));
  MeshReadReport report;
  road::read_mesh(obj("b.mtl"), {}, &report);
  ASSERT_EQ(report.remarks.size(), 1u);
  EXPECT_THAT(report.remarks[0], HasSubstr("b.mtl: is a device, a FIFO or a socket"));
}

std::string repeated(const std::string& text, std::size_t times) {
  std::string out;
  for (std::size_t i = 0; i < times; ++i) out += text;
  return out;
}

std::string as_glb_of(std::string json) {
  while (json.size() % 4 != 0) json += ' ';
  std::string bytes = "glTF";
  support::append(bytes, std::uint32_t{2});
  support::append(bytes, static_cast<std::uint32_t>(20 + json.size()));
  support::append(bytes, static_cast<std::uint32_t>(json.size()));
  return bytes + "JSON" + json;
}

TEST_F(ForeignMesh, RefusesNestingBeforeItsReaderSeesIt) {
  MeshReadOptions here;
  here.own_process = false;  // a crash would end the test
  const std::string arrays =
      "{\"asset\":{\"version\":\"2.0\"},\"extras\":" + repeated("[", 300'000) +
      repeated("]", 300'000) + "}";
  std::string chain =
      "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[";
  for (int i = 1; i < 20'000; ++i) chain += fmt::format("{{\"children\":[{}]}},", i);
  chain += "{}]}";
  const auto nodes = [](const std::string& list) {
    return "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[" +
           list + "]}";
  };
  std::string doubled;
  for (int i = 1; i < 60; ++i) doubled += fmt::format("{{\"children\":[{},{}]}},", i, i);
  const std::string forty = repeated("[", 40) + repeated("]", 40);
  const std::vector<std::tuple<std::string, std::string, std::string>> files{
      {"a.gltf", arrays, "arrays and objects are nested more than 1000 deep"},
      {"a.glb", as_glb_of(arrays), "arrays and objects are nested more than 1000 deep"},
      {"b.gltf", chain, "nodes are nested more than 1000 deep"},
      {"b.glb", as_glb_of(chain), "nodes are nested more than 1000 deep"},
      {"c.gltf", nodes("{\"children\":[1]},{\"children\":[0]}"), "is a child of itself"},
      {"d.gltf", nodes(doubled + "{}"), "nodes that are children of several"},
      {"e.gltf",
       "{\"asset\":{\"version\":\"1.0\"},\"nodes\":{\"a\":{\"children\":[\"b\"]},\"b\":{"
       "\"children\":[\"a\"]}}}",
       "is a child of itself"},
      {"a.dae",
       "<?xml version=\"1.0\"?><COLLADA version=\"1.4.1\"><!-- > "
       "--><library_visual_scenes><visual_scene id='<s'>" +
           repeated("<node>", 100'000) + repeated("</node>", 100'000) +
           "</visual_scene></library_visual_scenes></COLLADA>",
       "elements are nested more than 1000 deep"},
      {"a.x", "xof 0302txt 0064\n" + repeated("Frame a {\n", 100'000) + repeated("}", 100'000),
       "blocks are nested more than 1000 deep"},
      {"a.fbx", "; FBX 7.3.0 project file\n" + repeated("A: {\n", 200'000) + repeated("}", 200'000),
       "blocks are nested more than 1000 deep"}};
  for (const auto& [name, bytes, message] : files)
    EXPECT_THAT(message_of(folder_.file(name, bytes), here), HasSubstr(message)) << name;

  // What is nested as people nest, or has brackets in its names, passes.
  std::string glb = support::as_gltf(support::small_road(), "a.bin").gltf;
  glb.insert(1, "\"extras\":" + forty + ",");
  glb.replace(glb.find("\"root\""), 6, "\"" + repeated("[{\\\"", 2000) + "\"");
  glb.insert(glb.find("concrete"), "\xe9");  // Latin-1
  bin("a.bin");
  EXPECT_EQ(message_of(folder_.file("f.gltf", glb), here), "no error");
}

// Nested records of a binary .fbx: name A, no properties, the next record inside.
std::string nested_fbx(std::uint32_t depth) {
  std::string bytes = "Kaydara FBX Binary  ";
  bytes += std::string("\0\x1a\0", 3);
  support::append(bytes, std::uint32_t{7300});
  const auto end = static_cast<std::uint32_t>(bytes.size() + depth * (14 + 13));
  for (std::uint32_t i = 0; i < depth; ++i) {
    support::append(bytes, end - 13 * i);
    support::append(bytes, std::uint32_t{0});
    support::append(bytes, std::uint32_t{0});
    bytes += "\1A";
  }
  return bytes + std::string(13 * (depth + 1), '\0');
}

TEST_F(ForeignMesh, RefusesWhatCrashesItsReader) {
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THAT(message_of(folder_.file("a.fbx", nested_fbx(1'000'000))),
              testing::AllOf(HasSubstr("a.fbx: the reader of such files"),
                             HasSubstr("with another program")));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(30));
}

TEST_F(ForeignMesh, RefusesWhatAsksItsReaderForAllMemory) {
  EXPECT_THAT(message_of(folder_.file(
                  "a.dae",
                  "<?xml version=\"1.0\"?><COLLADA version=\"1.4.1\"><library_geometries><geometry "
                  "id=\"g\"><mesh><source id=\"s\"><float_array id=\"a\" count=\"4000000000\">0 0 0"
                  "</float_array></source></mesh></geometry></library_geometries></COLLADA>")),
              HasSubstr("a.dae: reading it needs far more memory than a mesh of"));
}

TEST_F(ForeignMesh, ReadsTheSameInAProcessOfItsOwn) {
  const Mesh road = support::small_road();
  bin("track/a.bin");
  for (const std::string& path :
       {gltf("a.bin"), obj("none.mtl"), folder_.file("a.glb", support::as_glb(road)),
        folder_.file("a.acc", support::as_acc(road)),
        folder_.file("b.obj", support::as_obj(road, 'z', {455'000.0, 5'300'000.0, 300.0}))}) {
    MeshReadOptions options;
    MeshReadReport apart_report, here_report;
    const Mesh apart = road::read_mesh(path, options, &apart_report);
    options.own_process = false;
    const Mesh here = road::read_mesh(path, options, &here_report);
    EXPECT_EQ(apart.origin_m, here.origin_m) << path;
    EXPECT_EQ(apart.vertices_m, here.vertices_m) << path;
    EXPECT_EQ(apart.triangles, here.triangles) << path;
    EXPECT_EQ(apart.object_of_triangle, here.object_of_triangle) << path;
    ASSERT_EQ(apart.objects.size(), here.objects.size()) << path;
    for (std::size_t i = 0; i < here.objects.size(); ++i) {
      EXPECT_EQ(apart.objects[i].name, here.objects[i].name);
      EXPECT_EQ(apart.objects[i].material, here.objects[i].material);
      EXPECT_EQ(apart.objects[i].texture, here.objects[i].texture);
    }
    EXPECT_EQ(apart_report.coordinate_resolution_m, here_report.coordinate_resolution_m) << path;
    EXPECT_EQ(apart_report.remarks, here_report.remarks) << path;
    ASSERT_EQ(apart_report.files.size(), here_report.files.size()) << path;
    for (std::size_t i = 0; i < here_report.files.size(); ++i) {
      EXPECT_EQ(apart_report.files[i].path, here_report.files[i].path);
      EXPECT_EQ(apart_report.files[i].sha256, here_report.files[i].sha256);
    }
  }
}

}  // namespace foreign_mesh_test
