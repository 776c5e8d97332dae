// A glTF that a test puts together from accessors of any kind.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/json_text.h"
#include "support/mesh_files.h"

namespace support {

/// Numbers one behind the other, as T.
template <class T, class Numbers>
std::string packed_as(const Numbers& numbers) {
  std::string bytes;
  for (const auto& number : numbers) append(bytes, static_cast<T>(number));
  return bytes;
}

/// One scene; `root` is open to every change.
struct GltfParts {
  nlohmann::json root = {{"asset", {{"version", "2.0"}}},
                         {"scene", 0},
                         {"scenes", {{{"nodes", nlohmann::json::array()}}}},
                         {"nodes", nlohmann::json::array()},
                         {"meshes", nlohmann::json::array()},
                         {"accessors", nlohmann::json::array()},
                         {"bufferViews", nlohmann::json::array()}};
  std::string bin;

  /// The number of a new view; `stride` 0: none.
  std::size_t add_view(const std::string& bytes, std::size_t stride = 0) {
    root["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", bytes.size()}});
    if (stride != 0) root["bufferViews"].back()["byteStride"] = stride;
    bin += bytes;
    while (bin.size() % 4 != 0) bin += '\0';
    return root["bufferViews"].size() - 1;
  }
  /// The number of a new accessor, on a new view where there are bytes.
  std::size_t add_accessor(const std::string& bytes, int component_type, std::size_t count,
                           const char* type, std::size_t stride = 0) {
    root["accessors"].push_back(
        {{"componentType", component_type}, {"count", count}, {"type", type}});
    if (!bytes.empty()) root["accessors"].back()["bufferView"] = add_view(bytes, stride);
    return root["accessors"].size() - 1;
  }
  std::size_t add_mesh(std::size_t positions, std::size_t indices) {
    root["meshes"].push_back(
        {{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}}}}});
    return root["meshes"].size() - 1;
  }
  /// The number of a new node of the scene.
  std::size_t add_node(nlohmann::json node) {
    root["scenes"][0]["nodes"].push_back(root["nodes"].size());
    root["nodes"].push_back(std::move(node));
    return root["nodes"].size() - 1;
  }
  GltfAndBin with_bin(const std::string& uri) const {
    nlohmann::json whole = root;
    whole["buffers"] = {{{"byteLength", bin.size()}, {"uri", uri}}};
    return {base::dump_json(whole), bin};
  }
  std::string glb() const {
    nlohmann::json whole = root;
    whole["buffers"] = {{{"byteLength", bin.size()}}};
    std::string json = base::dump_json(whole);
    while (json.size() % 4 != 0) json += ' ';
    std::string bytes = "glTF";
    append(bytes, std::uint32_t{2});
    append(bytes, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + bin.size()));
    append(bytes, static_cast<std::uint32_t>(json.size()));
    bytes += "JSON" + json;
    append(bytes, static_cast<std::uint32_t>(bin.size()));
    return bytes + std::string("BIN\0", 4) + bin;
  }
};

/// A flat strip of 200 x 20 as integers with 100 for 1.0, from the origin along x and -z (y is up):
/// 11 x 2 vertices.
inline std::vector<int> strip_numbers() {
  std::vector<int> numbers;
  for (int i = 0; i <= 10; ++i)
    for (const int z : {0, -10}) numbers.insert(numbers.end(), {10 * i, i % 3, z});
  return numbers;
}

/// Its triangles, seen from above counterclockwise.
inline std::vector<int> strip_indices() {
  std::vector<int> indices;
  for (int i = 0; i < 20; i += 2) indices.insert(indices.end(), {i, i + 2, i + 3, i, i + 3, i + 1});
  return indices;
}

/// The strip in every way at once that assimp does not know: int16 normalised, sparse, shown three
/// times, one of them mirrored.
inline GltfParts busy_gltf() {
  GltfParts parts;
  const std::size_t positions =
      parts.add_accessor(packed_as<std::int16_t>(strip_numbers()), 5122, 22, "VEC3");
  parts.root["accessors"][positions]["normalized"] = true;
  parts.root["accessors"][positions]["sparse"] = {
      {"count", 1},
      {"indices",
       {{"bufferView", parts.add_view(packed_as<std::uint8_t>(std::vector{3}))},
        {"componentType", 5121}}},
      {"values",
       {{"bufferView", parts.add_view(packed_as<std::int16_t>(std::vector{10, 1, -12}))}}}};
  const std::size_t indices =
      parts.add_accessor(packed_as<std::uint16_t>(strip_indices()), 5123, 60, "SCALAR");
  const std::size_t places = parts.add_accessor(
      packed_as<float>(std::vector{0.0, 0.0, 0.0, 0.0, 0.0, 1e-3, 0.0, 0.0, 2e-3}), 5126, 3,
      "VEC3");
  const std::size_t turns = parts.add_accessor(
      packed_as<std::int8_t>(std::vector{0, 0, 0, 127, 0, 127, 0, 0, 0, 0, 0, 127}), 5120, 3,
      "VEC4");
  const std::size_t scales = parts.add_accessor(
      packed_as<float>(std::vector{1, 1, 1, 1, 1, 1, -1, 1, 1}), 5126, 3, "VEC3");
  parts.root["accessors"][turns]["normalized"] = true;
  parts.add_node(
      {{"name", "road"},
       {"mesh", parts.add_mesh(positions, indices)},
       {"scale", {65534, 1000, 65534}},
       {"extensions",
        {{"EXT_mesh_gpu_instancing",
          {{"attributes", {{"TRANSLATION", places}, {"ROTATION", turns}, {"SCALE", scales}}}}}}}});
  parts.root["extensionsUsed"] =
      parts.root["extensionsRequired"] = {"KHR_mesh_quantization", "EXT_mesh_gpu_instancing"};
  return parts;
}

}  // namespace support
