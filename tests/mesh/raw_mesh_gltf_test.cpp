// glTF with what assimp does not know: instances, integers, sparse accessors, required extensions.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <numbers>

#include "mesh/error.h"
#include "mesh/read_mesh.h"
#include "support/gltf_parts.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace raw_mesh_gltf_test {

using Eigen::Vector3d;
using nlohmann::json;
using road::Mesh;
using support::GltfParts;
using support::packed_as;
using support::strip_indices;
using support::strip_numbers;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kInt8 = 5120, kUint8 = 5121, kInt16 = 5122, kUint16 = 5123, kUint32 = 5125,
              kFloat = 5126;

class ReadGltf : public ::testing::Test {
 protected:
  Mesh read(const GltfParts& parts, road::MeshReadReport* report = nullptr) {
    return road::read_mesh(folder_.file("a.glb", parts.glb()), {}, report);
  }
  std::string refusal(const GltfParts& parts) {
    road::MeshReadOptions here;
    here.own_process = false;
    try {
      road::read_mesh(folder_.file("a.glb", parts.glb()), here);
    } catch (const road::Error& error) {
      return error.what();
    }
    return "no error";
  }
  support::TemporaryFolder folder_;
};

/// The strip with indices, and a node that scales it to 200 m x 20 m.
GltfParts strip(std::size_t (*add_positions)(GltfParts&), double scale = 2.0) {
  GltfParts parts;
  const std::size_t positions = add_positions(parts);
  const std::size_t indices =
      parts.add_accessor(packed_as<std::uint16_t>(strip_indices()), kUint16, 60, "SCALAR");
  parts.add_node({{"name", "road"},
                  {"mesh", parts.add_mesh(positions, indices)},
                  {"scale", {scale, 0.1 * scale, scale}}});
  return parts;
}

std::size_t as_floats(GltfParts& parts) {
  return parts.add_accessor(packed_as<float>(strip_numbers()), kFloat, 22, "VEC3");
}

/// The corners of all triangles as glTF has them.
std::vector<Vector3d> corners(const Mesh& mesh) {
  std::vector<Vector3d> out;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int c = 0; c < 3; ++c) {
      const Vector3d p = mesh.origin_m + mesh.vertex(t, c);
      out.emplace_back(p.x(), p.z(), -p.y());
    }
  return out;
}

double farthest(const std::vector<Vector3d>& expected, const std::vector<Vector3d>& seen) {
  if (expected.size() != seen.size()) return 1e9;
  double most = 0.0;
  for (std::size_t i = 0; i < expected.size(); ++i)
    most = std::max(most, (expected[i] - seen[i]).norm());
  return most;
}

/// Area in plan, of what faces up and of what faces down.
std::pair<double, double> areas(const Mesh& mesh) {
  double up = 0.0, down = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double area =
        0.5 *
        (mesh.vertex(t, 1) - mesh.vertex(t, 0)).cross(mesh.vertex(t, 2) - mesh.vertex(t, 0)).z();
    (area > 0.0 ? up : down) += std::abs(area);
  }
  return {up, down};
}

template <class T>
std::string padded(std::size_t stride) {
  std::string bytes;
  const std::vector<int> numbers = strip_numbers();
  for (std::size_t i = 0; i < numbers.size(); i += 3) {
    std::string element = packed_as<T>(std::vector(&numbers[i], &numbers[i] + 3));
    element.resize(stride, '\x55');
    bytes += element;
  }
  return bytes;
}

template <class T, int type, std::size_t stride>
std::size_t add_normalised(GltfParts& parts) {
  const std::size_t number = parts.add_accessor(padded<T>(stride), type, 22, "VEC3", stride);
  parts.root["accessors"][number]["normalized"] = true;
  return number;
}

TEST_F(ReadGltf, ReadsPositionsThatAreIntegers) {
  const std::vector<Vector3d> expected = corners(read(strip(as_floats)));
  road::MeshReadReport report;
  const Mesh shorts =
      read(strip([](GltfParts& parts) {
             return parts.add_accessor(padded<std::int16_t>(8), kInt16, 22, "VEC3", 8);
           }),
           &report);
  EXPECT_EQ(farthest(expected, corners(shorts)), 0.0);
  EXPECT_THAT(report.remarks,
              testing::ElementsAre(
                  AllOf(HasSubstr("snap to 2000.0 mm at most (object '"), HasSubstr("-noq"))));
  EXPECT_EQ(farthest(expected, corners(read(strip([](GltfParts& parts) {
                       return parts.add_accessor(padded<std::int8_t>(4), kInt8, 22, "VEC3", 4);
                     })))),
            0.0);
  // Normalised: 1.0 is the largest integer.
  EXPECT_LT(farthest(expected,
                     corners(read(strip(add_normalised<std::int16_t, kInt16, 8>, 2.0 * 32767)))),
            2e-5);
  EXPECT_LT(
      farthest(expected, corners(read(strip(add_normalised<std::int8_t, kInt8, 4>, 2.0 * 127)))),
      2e-5);
  // -32768 is -1.0 as well.
  GltfParts lowest = strip(as_floats);
  std::vector<int> numbers = strip_numbers();
  for (int& number : numbers) number = number < -5 ? -32768 : 327 * number;
  lowest.root["accessors"][0] = {{"componentType", kInt16},
                                 {"normalized", true},
                                 {"count", 22},
                                 {"type", "VEC3"},
                                 {"bufferView", lowest.add_view(packed_as<std::int16_t>(numbers))}};
  lowest.root["nodes"][0]["scale"] = {200, 20, 200};
  double least = 0.0;
  for (const Vector3d& corner : corners(read(lowest))) least = std::min(least, corner.z());
  EXPECT_NEAR(least, -200.0, 1e-9);
}

TEST_F(ReadGltf, ReadsUnsignedPositionsAndForgetsWhatNobodyAsksFor) {
  GltfParts parts = strip([](GltfParts& p) {
    std::vector<int> up = strip_numbers();
    for (std::size_t i = 2; i < up.size(); i += 3) up[i] += 10;  // z from 0 on
    const std::size_t number = p.add_accessor(packed_as<std::uint16_t>(up), kUint16, 22, "VEC3");
    p.root["accessors"][number]["normalized"] = true;
    return number;
  });
  json& attributes = parts.root["meshes"][0]["primitives"][0]["attributes"];
  attributes["NORMAL"] = parts.add_accessor(std::string(66, '\x7f'), kInt8, 22, "VEC3");
  attributes["TEXCOORD_0"] = parts.add_accessor(std::string(88, '\x7f'), kUint16, 22, "VEC2");
  parts.root["nodes"][0]["scale"] = {2.0 * 65535, 0.2 * 65535, 2.0 * 65535};
  parts.root["nodes"][0]["translation"] = {0, 0, -20};
  parts.root["extensionsRequired"] = {"KHR_mesh_quantization"};
  EXPECT_LT(farthest(corners(read(strip(as_floats))), corners(read(parts))), 3e-5);
}

TEST_F(ReadGltf, ReadsSparseAccessors) {
  std::vector<Vector3d> expected = corners(read(strip(as_floats)));
  // Vertex 3 lies elsewhere: (10, 1, -10), and (10, 5, -12) twice as large.
  for (Vector3d& corner : expected)
    if ((corner - Vector3d(20.0, 0.2, -20.0)).norm() < 1e-3) corner = Vector3d(20.0, 1.0, -24.0);
  for (const bool interleaved : {false, true}) {
    GltfParts parts;
    std::string bytes;
    const std::vector<int> numbers = strip_numbers();
    for (std::size_t i = 0; i < numbers.size(); i += 3) {
      bytes += packed_as<float>(std::vector(&numbers[i], &numbers[i] + 3));
      if (interleaved) bytes += "four";
    }
    const std::size_t positions =
        parts.add_accessor(bytes, kFloat, 22, "VEC3", interleaved ? 16 : 0);
    parts.root["accessors"][positions]["sparse"] = {
        {"count", 1},
        {"indices",
         {{"bufferView", parts.add_view(packed_as<std::uint16_t>(std::vector{7, 3}))},
          {"byteOffset", 2},
          {"componentType", kUint16}}},
        {"values", {{"bufferView", parts.add_view(packed_as<float>(std::vector{10, 5, -12}))}}}};
    // Triangles that are zeros but for what is sparse.
    const std::vector<int> indices = strip_indices();
    std::vector<int> all(60);
    for (int i = 0; i < 60; ++i) all[static_cast<std::size_t>(i)] = i;
    const std::size_t triangles = parts.add_accessor("", kUint16, 60, "SCALAR");
    parts.root["accessors"][triangles]["sparse"] = {
        {"count", 60},
        {"indices",
         {{"bufferView", parts.add_view(packed_as<std::uint32_t>(all))},
          {"componentType", kUint32}}},
        {"values", {{"bufferView", parts.add_view(packed_as<std::uint16_t>(indices))}}}};
    parts.add_node({{"mesh", parts.add_mesh(positions, triangles)}, {"scale", {2.0, 0.2, 2.0}}});
    EXPECT_LT(farthest(expected, corners(read(parts))), 1e-5) << interleaved;
  }
}

TEST_F(ReadGltf, ShowsAMeshWhereverItsInstancesLie) {
  GltfParts parts = strip(as_floats);
  const std::vector<Vector3d> once = corners(read(parts));
  // A second mesh below the node is shown once, whatever its parent's instances.
  const std::size_t child = parts.root["nodes"].size();
  parts.root["nodes"].push_back({{"name", "sign"}, {"mesh", 0}, {"translation", {0, 5000, 0}}});
  parts.root["nodes"][0]["children"] = {child};
  parts.root["nodes"][0]["translation"] = {7, 0, 0};
  const double s = std::sqrt(0.5);
  const std::size_t places = parts.add_accessor(
      packed_as<float>(std::vector{0.0, 0.0, 0.0, 5.0, 50.0, -60.0}), kFloat, 2, "VEC3");
  const std::size_t turns = parts.add_accessor(
      packed_as<float>(std::vector{0.0, 0.0, 0.0, 1.0, 0.0, s, 0.0, s}), kFloat, 2, "VEC4");
  const std::size_t scales = parts.add_accessor(
      packed_as<float>(std::vector{1.0, 1.0, 1.0, 1.0, 3.0, 0.5}), kFloat, 2, "VEC3");
  const std::size_t ids = parts.add_accessor(std::string("\0\1", 2), kUint8, 2, "SCALAR");
  json& node = parts.root["nodes"][0];
  node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", places}, {"ROTATION", turns}, {"SCALE", scales}, {"_ID", ids}};
  std::vector<Vector3d> expected;
  expected.reserve(3 * once.size());
  for (const Vector3d& p : once) expected.emplace_back(p + Vector3d(7, 0, 0));
  for (const Vector3d& p : once) {
    // Scaled, a quarter turn about y (x -> -z), moved; then by the node: 2, 0.2, 2 and 7 m.
    const Vector3d in_mesh(p.x() / 2, p.y() / 0.2 * 3, p.z() / 2 * 0.5);
    const Vector3d in_node =
        Vector3d(in_mesh.z(), in_mesh.y(), -in_mesh.x()) + Vector3d(5, 50, -60);
    expected.emplace_back(2 * in_node.x() + 7, 0.2 * in_node.y(), 2 * in_node.z());
  }
  for (const Vector3d& p : once) expected.emplace_back(p + Vector3d(7, 1000, 0));
  road::MeshReadReport report;
  const Mesh seen = read(parts, &report);
  EXPECT_LT(farthest(expected, corners(seen)), 1e-4);
  EXPECT_TRUE(report.remarks.empty());
  ASSERT_EQ(seen.objects.size(), 2u) << "all instances are one object";
  EXPECT_EQ(seen.objects[1].name, "sign");

  // Rotations as integers; what is not given is the identity.
  for (const auto& [bytes, type] :
       {std::pair{packed_as<std::int8_t>(std::vector{0, 0, 0, 127, 0, 127, 0, 0}), kInt8},
        {packed_as<std::int16_t>(std::vector{0, 0, 0, 32767, 0, 32767, 0, 0}), kInt16}}) {
    GltfParts turned = strip(as_floats);
    const std::size_t number = turned.add_accessor(bytes, type, 2, "VEC4");
    turned.root["accessors"][number]["normalized"] = true;
    turned.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"ROTATION", number}};
    std::vector<Vector3d> both = once;
    for (const Vector3d& p : once) both.emplace_back(-p.x(), p.y(), -p.z());
    EXPECT_LT(farthest(both, corners(read(turned))), 1e-4) << type;
  }
}

TEST_F(ReadGltf, BoundsInstances) {
  const auto with = [](std::size_t count) {
    GltfParts parts = strip(as_floats);
    parts.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", parts.add_accessor("", kFloat, count, "VEC3")}};
    return parts;
  };
  EXPECT_EQ(refusal(with(3)), "no error");
  EXPECT_THAT(refusal(with(4'000'000'000)),
              AllOf(HasSubstr("a.glb: node 0 ('road') shows its mesh many times"),
                    HasSubstr("4000000000 instances are declared, too many"),
                    HasSubstr("export it again")));
  EXPECT_THAT(refusal(with(18'446'744'073'709'551'615u)), HasSubstr("too many"));
  EXPECT_THAT(refusal(with(0)), HasSubstr("no triangles"));

  GltfParts unequal = with(2);
  unequal.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] =
      unequal.add_accessor("", kFloat, 3, "VEC3");
  EXPECT_THAT(refusal(unequal), HasSubstr("instances by one attribute"));
  for (const json& attributes :
       {json(nullptr), json::object(), json(7), json{{"TRANSLATION", 77}}, json{{"ROTATION", 0}},
        json{{"SCALE", -1}}, json{{"TRANSLATION", "x"}}}) {
    GltfParts damaged = with(2);
    damaged.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = attributes;
    EXPECT_THAT(refusal(damaged), HasSubstr("shows its mesh many times")) << attributes;
  }

  // A mesh of 60,000 triangles, 800 times.
  GltfParts large = with(800);
  std::string many;
  for (int i = 0; i < 3000; ++i) many += packed_as<std::uint16_t>(strip_indices());
  large.root["meshes"][0]["primitives"][0]["indices"] =
      large.add_accessor(many, kUint16, 180'000, "SCALAR");
  EXPECT_THAT(refusal(large), AllOf(HasSubstr("is shown 800 times"), HasSubstr("leave out")));
}

TEST_F(ReadGltf, BoundsAccessors) {
  const auto changed = [&](const json& patch) {
    GltfParts parts = strip([](GltfParts& p) {
      return p.add_accessor(packed_as<std::int16_t>(strip_numbers()), kInt16, 22, "VEC3");
    });
    parts.root["accessors"][0].merge_patch(patch);
    return refusal(parts);
  };
  EXPECT_EQ(changed(json::object()), "no error");
  EXPECT_THAT(changed({{"count", 23}}),
              AllOf(HasSubstr("a.glb: mesh 0 cannot be read: 23 elements, 6 bytes apart"),
                    HasSubstr("export it again")));
  EXPECT_THAT(changed({{"count", 4'000'000'000u}}), HasSubstr("too many for a file of"));
  EXPECT_THAT(changed({{"byteOffset", 2}}), HasSubstr("do not fit"));
  EXPECT_THAT(changed({{"byteOffset", 4'000'000'000u}}), HasSubstr("do not fit"));
  EXPECT_THAT(changed({{"componentType", 5124}}), HasSubstr("componentType 5124"));
  EXPECT_THAT(changed({{"type", "VEC2"}}), HasSubstr("is no VEC3"));
  EXPECT_THAT(changed({{"bufferView", 99}}), HasSubstr("cannot be read"));
  EXPECT_THAT(changed({{"bufferView", nullptr}, {"count", 900'000'000}}), HasSubstr("too many"));
  json sparse = {{"count", 1},
                 {"indices", {{"bufferView", 1}, {"componentType", kUint16}}},
                 {"values", {{"bufferView", 0}}}};
  EXPECT_EQ(changed({{"sparse", sparse}}), "no error");
  const auto sparsely = [&](const json& patch) {
    json with = sparse;
    with.merge_patch(patch);
    return changed({{"sparse", with}});
  };
  EXPECT_THAT(sparsely({{"count", 23}}), HasSubstr("changes 23 of 22 elements"));
  EXPECT_THAT(sparsely({{"indices", {{"byteOffset", 118}}}}), HasSubstr("no error"));
  EXPECT_THAT(sparsely({{"indices", {{"byteOffset", 119}}}}), HasSubstr("do not fit"));
  EXPECT_THAT(sparsely({{"indices", {{"bufferView", 0}, {"byteOffset", 10}}}}),
              HasSubstr("changes element 65526 of 22"));
  EXPECT_THAT(sparsely({{"values", nullptr}}), HasSubstr("cannot be read"));
}

TEST_F(ReadGltf, RefusesByNameWhatAFileRequiresAndIsNotRead) {
  const auto requiring = [&](const json& names) {
    GltfParts parts = strip(as_floats);
    parts.root["extensionsUsed"] = parts.root["extensionsRequired"] = names;
    return refusal(parts);
  };
  EXPECT_THAT(requiring({"EXT_meshopt_compression"}),
              AllOf(HasSubstr("a.glb: this glTF requires 'EXT_meshopt_compression', which is not "
                              "read; export it again without"),
                    HasSubstr("gltfpack: without -c")));
  EXPECT_THAT(requiring({"KHR_node_visibility", "KHR_mesh_quantization", "ACME_bent_space"}),
              HasSubstr("requires 'KHR_node_visibility', 'ACME_bent_space', which"));
  EXPECT_EQ(requiring({"KHR_materials_unlit", "KHR_texture_transform", "KHR_lights_punctual",
                       "EXT_structural_metadata", "EXT_mesh_features", "KHR_techniques_webgl",
                       "EXT_mesh_gpu_instancing", "KHR_mesh_quantization", 7}),
            "no error");
  GltfParts used = strip(as_floats);
  used.root["extensionsUsed"] = {"ACME_bent_space", "EXT_meshopt_compression"};
  EXPECT_EQ(refusal(used), "no error");
}

TEST_F(ReadGltf, KeepsTheUpperSideOfMirroredInstances) {
  const auto [up, down] = areas(read(support::busy_gltf()));
  EXPECT_NEAR(up, 3 * (200.0 * 20.0 + 0.5 * 4.0 * 40.0), 1.0);
  EXPECT_EQ(down, 0.0);
}

TEST_F(ReadGltf, ReadsBuffersBesideTheMesh) {
  const GltfParts parts = support::busy_gltf();
  folder_.file("a.bin", parts.bin);
  const Mesh seen = road::read_mesh(folder_.file("a.gltf", parts.with_bin("a.bin").gltf));
  EXPECT_EQ(farthest(corners(read(parts)), corners(seen)), 0.0);
  folder_.file("a.bin", "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n");
  try {
    road::read_mesh(folder_.path("a.gltf"));
    FAIL();
  } catch (const road::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("a.bin: is a pointer of Git LFS"));
  }
}

TEST(ReadGltfOpen, ReadsRingsThatAreStoredInManyWays) {
  for (const char* name : {"plain", "mirrored_node", "quantised", "instanced4"}) {
    const std::string path = fmt::format("{}/constructed/ring_r200_{}.glb", places::data(), name);
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent";
    const Mesh mesh = road::read_mesh(path);
    const auto [up, down] = areas(mesh);
    // From 194 to 206 m in 360 pieces, each of which is a chord.
    EXPECT_NEAR(up, std::numbers::pi * (206.0 * 206.0 - 194.0 * 194.0), 2.0) << name;
    EXPECT_EQ(down, 0.0) << name;
    Vector3d lowest = Vector3d::Constant(1e9), highest = -lowest;
    for (const Vector3d& corner : corners(mesh)) {
      lowest = lowest.cwiseMin(corner);
      highest = highest.cwiseMax(corner);
    }
    const double height = name == std::string("instanced4") ? 0.0 : 5.0;
    EXPECT_LT((highest - Vector3d(206, height, 206)).norm(), 0.01) << name;
    EXPECT_LT((lowest + Vector3d(206, height, 206)).norm(), 0.01) << name;
  }
}

}  // namespace raw_mesh_gltf_test
