// glTF compressed by Draco is the mesh that it was before.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "base/json_text.h"
#include "base/read_file.h"
#include "mesh/error.h"
#include "mesh/read_mesh.h"
#include "support/draco_gltf.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace raw_mesh_draco_test {

using road::Mesh;
using support::DracoMethod;
using ::testing::HasSubstr;

std::string message_of(const std::string& path, const road::MeshReadOptions& options = {}) {
  try {
    road::read_mesh(path, options);
  } catch (const road::Error& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return error.what();
  }
  return "no error";
}

/// How far a corner of a triangle of `expected` lies from that of its counterpart in `seen`, at
/// most. Draco writes triangles in another order and turns them, but keeps which side is up.
double farthest_corner_m(const Mesh& expected, const Mesh& seen) {
  std::set<std::size_t> free;
  for (std::size_t t = 0; t < seen.triangles.size(); ++t) free.insert(t);
  double farthest_m = 0.0;
  for (std::size_t t = 0; t < expected.triangles.size(); ++t) {
    double best_m = std::numeric_limits<double>::infinity();
    std::size_t best = 0;
    for (const std::size_t other : free) {
      if (expected.objects[expected.object_of_triangle[t]].name !=
              seen.objects[seen.object_of_triangle[other]].name ||
          expected.objects[expected.object_of_triangle[t]].material !=
              seen.objects[seen.object_of_triangle[other]].material)
        continue;
      for (int turn = 0; turn < 3; ++turn) {
        double most_m = 0.0;
        for (int c = 0; c < 3; ++c)
          most_m = std::max(most_m, (expected.origin_m + expected.vertex(t, c) - seen.origin_m -
                                     seen.vertex(other, (c + turn) % 3))
                                        .norm());
        if (most_m < best_m) best_m = most_m, best = other;
      }
    }
    if (!std::isfinite(best_m)) return best_m;
    free.erase(best);
    farthest_m = std::max(farthest_m, best_m);
  }
  return free.empty() ? farthest_m : std::numeric_limits<double>::infinity();
}

TEST(ReadDraco, GivesTheTrianglesOfThePlainMesh) {
  const support::TemporaryFolder folder;
  const Mesh road = support::small_road();
  const Mesh plain = road::read_mesh(folder.file("plain.glb", support::as_glb(road)));
  for (const DracoMethod method : {DracoMethod::edgebreaker, DracoMethod::sequential}) {
    for (const bool metadata : {false, true}) {
      for (const int bits : {11, 14, 20}) {
        // Draco cuts the longest side of the box, 200 m, into 2^bits - 1 steps, along each axis
        // alike: a corner moves by half a step at most in each, and by the float32 of 200 m (8 um).
        const double tolerance_m =
            std::sqrt(3.0) * 0.5 * 200.0 / (std::pow(2.0, bits) - 1.0) + 2e-5;
        const std::string path =
            folder.file("a.glb", support::as_draco_glb(road, method, bits, metadata));
        road::MeshReadReport report;
        const Mesh seen = road::read_mesh(path, {}, &report);
        EXPECT_LT(farthest_corner_m(plain, seen), tolerance_m) << bits;
        EXPECT_EQ(report.unit, "m");
        EXPECT_TRUE(report.remarks.empty());
        EXPECT_TRUE(report.files.empty());
      }
    }
  }
}

TEST(ReadDraco, ReadsBuffersBesideTheMeshAndInIt) {
  const support::TemporaryFolder folder;
  const Mesh road = support::small_road();
  support::GltfAndBin parts = support::as_draco_gltf(road, "a.bin", DracoMethod::edgebreaker, 16);
  const std::string bin = folder.file("a.bin", parts.bin);
  road::MeshReadReport report;
  const Mesh seen = road::read_mesh(folder.file("a.gltf", parts.gltf), {}, &report);
  EXPECT_LT(farthest_corner_m(road, seen), 3e-3);
  ASSERT_EQ(report.files.size(), 1u);
  EXPECT_EQ(report.files[0].path, bin);

  const std::string characters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string base64;
  for (std::size_t i = 0; i < parts.bin.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = i; k < i + 3; ++k)
      bits = 256 * bits + (k < parts.bin.size() ? static_cast<unsigned char>(parts.bin[k]) : 0);
    for (int shift = 18; shift >= 0; shift -= 6) base64 += characters[bits >> shift & 63];
  }
  const std::string inside =
      support::as_draco_gltf(road, "data:application/octet-stream;base64," + base64,
                             DracoMethod::edgebreaker, 16)
          .gltf;
  EXPECT_LT(farthest_corner_m(road, road::read_mesh(folder.file("b.gltf", inside))), 3e-3);

  std::filesystem::create_directories(folder.path("track"));
  const std::string outside = folder.file(
      "track/c.gltf", support::as_draco_gltf(road, "../a.bin", DracoMethod::edgebreaker, 16).gltf);
  EXPECT_THAT(message_of(outside),
              testing::AllOf(HasSubstr("a.bin' lies outside"), HasSubstr("--allow-outside")));
  road::MeshReadOptions anywhere;
  anywhere.allow_outside = true;
  EXPECT_EQ(message_of(outside, anywhere), "no error");
  std::filesystem::remove(bin);
  EXPECT_THAT(message_of(folder.path("a.gltf")), HasSubstr("buffer 'a.bin' is not read"));
}

TEST(ReadDraco, RefusesWhatIsDamagedOrDeclaresTooMuch) {
  const support::TemporaryFolder folder;
  road::MeshReadOptions here;
  here.own_process = false;
  const support::GltfAndBin parts =
      support::as_draco_gltf(support::small_road(), "a.bin", DracoMethod::sequential, 14);
  const auto refusal = [&](const auto& damage) {
    support::GltfAndBin damaged = parts;
    damage(damaged);
    folder.file("a.bin", damaged.bin);
    return message_of(folder.file("a.gltf", damaged.gltf), here);
  };
  EXPECT_EQ(refusal([](auto&) {}), "no error");
  // Behind the head of 11 bytes: the numbers of faces and points, seven bits a byte.
  EXPECT_THAT(
      refusal([](auto& p) { p.bin.replace(11, 2, "\xff\xff\xff\xff\x0f\x03", 6); }),
      testing::AllOf(
          HasSubstr(
              "a.gltf: mesh 0 is compressed by Draco and cannot be read: 4294967295 triangles"),
          HasSubstr("export it again, or without compression")));
  EXPECT_THAT(refusal([](auto& p) { p.bin[0] = 'X'; }), HasSubstr("no data of Draco"));
  EXPECT_THAT(refusal([](auto& p) { p.bin[6] = 1; }),
              HasSubstr("version 2.1 of Draco; wanted 2.2"));
  EXPECT_THAT(refusal([](auto& p) { p.bin[7] = 0; }), HasSubstr("points without triangles"));
  EXPECT_THAT(refusal([](auto& p) { p.bin.resize(12); }), HasSubstr("of a buffer of 12"));
  EXPECT_THAT(refusal([](auto& p) { p.bin.replace(13, 40, 40, '\xff'); }),
              HasSubstr("cannot be read"));
  const auto changed = [&](const std::string& from, const std::string& to) {
    return refusal([&](auto& p) {
      ASSERT_NE(p.gltf.find(from), std::string::npos);
      p.gltf.replace(p.gltf.find(from), from.size(), to);
    });
  };
  EXPECT_THAT(changed("{\"POSITION\":0},\"bufferView\":0", "{\"POSITION\":9},\"bufferView\":0"),
              HasSubstr("no positions"));
  EXPECT_THAT(changed("{\"POSITION\":0},\"bufferView\":0", "{\"POSITION\":0},\"bufferView\":77"),
              HasSubstr("cannot be read"));
  EXPECT_THAT(changed("{\"POSITION\":0},\"bufferView\":0", "{\"POSITION\":0},\"bufferView\":-1"),
              HasSubstr("no whole number"));
  EXPECT_THAT(changed("{\"attributes\":{\"POSITION\":0},\"bufferView\":0}", "[]"),
              HasSubstr("cannot be read"));
}

TEST(ReadDraco, BoundsManyMeshesOfTheSameBytes) {
  // 3,000 primitives that all show the same 40 triangles are read; of the same 8,000 they are too
  // many.
  const support::TemporaryFolder folder;
  const support::GltfAndBin parts =
      support::as_draco_gltf(support::small_road(), "a.bin", DracoMethod::sequential, 14);
  auto root = base::parse_json<nlohmann::json>(parts.gltf);
  const auto primitive = root["meshes"][0]["primitives"][0];
  for (int i = 0; i < 3000; ++i) root["meshes"][0]["primitives"].push_back(primitive);
  folder.file("a.bin", parts.bin);
  EXPECT_EQ(road::read_mesh(folder.file("a.gltf", base::dump_json(root))).triangles.size(),
            3002u * 40u);
  auto large = support::small_road();
  const Mesh once = large;
  for (int i = 1; i < 200; ++i) {
    const auto base = static_cast<std::uint32_t>(large.vertices_m.size());
    for (const auto& v : once.vertices_m)
      large.vertices_m.push_back(v + Eigen::Vector3d(0, 20.0 * i, 0));
    for (std::size_t t = 0; t < once.triangles.size(); ++t) {
      const auto& corners = once.triangles[t];
      large.triangles.push_back({corners[0] + base, corners[1] + base, corners[2] + base});
      large.object_of_triangle.push_back(once.object_of_triangle[t]);
    }
  }
  const support::GltfAndBin parts_large =
      support::as_draco_gltf(large, "b.bin", DracoMethod::edgebreaker, 14);
  root = base::parse_json<nlohmann::json>(parts_large.gltf);
  auto& primitives = root["meshes"][0]["primitives"];
  const auto shown = primitives[0];
  for (int i = 0; i < 3000; ++i) primitives.push_back(shown);
  folder.file("b.bin", parts_large.bin);
  EXPECT_THAT(message_of(folder.file("b.gltf", base::dump_json(root))),
              HasSubstr("too many for a file of"));
}

TEST(ReadDraco, ReadsAnOpenMeshWhole) {
  const std::string path = places::data() + "/meshes/pmndrs_track_draco.glb";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent";
  // What the exporter wrote beside the compressed bytes: numbers of corners, and the boxes before
  // compression.
  const std::string bytes = base::read_file(path);
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, sizeof length);
  const auto root = base::parse_json<nlohmann::json>(bytes.substr(20, length));
  std::size_t corners = 0;
  for (const auto& node : root["nodes"])
    for (const auto& primitive : root["meshes"][node["mesh"].get<std::size_t>()]["primitives"])
      corners +=
          root["accessors"][primitive["indices"].get<std::size_t>()]["count"].get<std::size_t>();
  const Mesh mesh = road::read_mesh(path);
  EXPECT_EQ(mesh.triangles.size(), corners / 3);
  EXPECT_EQ(mesh.triangles.size(), 120720u);

  // The node 'track' is not moved: glTF (x, y, z) is (x, -z, y) here.
  const auto& track = root["meshes"][3]["primitives"];
  ASSERT_EQ(root["nodes"][3]["name"], "track");
  ASSERT_EQ(track.size(), 2u);
  for (const auto& primitive : track) {
    const auto& box = root["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()];
    const std::string material =
        root["materials"][primitive["material"].get<std::size_t>()]["name"];
    Eigen::Vector3d lowest = Eigen::Vector3d::Constant(1e9), highest = -lowest;
    std::size_t triangles = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const road::MeshObject& object = mesh.objects[mesh.object_of_triangle[t]];
      if (object.name != "track" || object.material != material) continue;
      ++triangles;
      for (int c = 0; c < 3; ++c) {
        lowest = lowest.cwiseMin(mesh.origin_m + mesh.vertex(t, c));
        highest = highest.cwiseMax(mesh.origin_m + mesh.vertex(t, c));
      }
    }
    EXPECT_EQ(
        3 * triangles,
        root["accessors"][primitive["indices"].get<std::size_t>()]["count"].get<std::size_t>());
    // The exporter cut the longest side into 1,024 steps (of 0.46 m) and wrote boxes half a step
    // wider.
    Eigen::Vector3d written_low, written_high;
    for (int axis = 0; axis < 3; ++axis) {
      written_low[axis] = box["min"][static_cast<std::size_t>(axis)].get<double>();
      written_high[axis] = box["max"][static_cast<std::size_t>(axis)].get<double>();
    }
    const double half_step_m = (written_high - written_low).maxCoeff() / 1025.0 / 2.0;
    const Eigen::Vector3d low(lowest.x(), lowest.z(), -highest.y()),
        high(highest.x(), highest.z(), -lowest.y());
    EXPECT_LT(((low - written_low).array() - half_step_m).abs().maxCoeff(), 1e-3);
    EXPECT_LT(((written_high - high).array() - half_step_m).abs().maxCoeff(), 1e-3);
  }
}

}  // namespace raw_mesh_draco_test
