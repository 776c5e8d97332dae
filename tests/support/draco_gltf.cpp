#include "support/draco_gltf.h"

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "base/json_text.h"

namespace support {
namespace {

using Json = nlohmann::json;

/// `positions`: three corners of each triangle, three float32 each.
std::string packed(std::string_view positions, DracoMethod method, int bits, bool with_metadata) {
  const auto triangles = static_cast<int>(positions.size() / 36);
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(triangles);
  const int id = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  for (int t = 0; t < triangles; ++t) {
    const char* corner = positions.data() + 36 * static_cast<std::size_t>(t);
    builder.SetAttributeValuesForFace(id, draco::FaceIndex(static_cast<std::uint32_t>(t)), corner,
                                      corner + 12, corner + 24);
  }
  const auto mesh = builder.Finalize();
  if (with_metadata) {
    auto metadata = std::make_unique<draco::GeometryMetadata>();
    metadata->AddEntryString("made by", "a test");
    mesh->AddMetadata(std::move(metadata));
  }
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method == DracoMethod::sequential ? draco::MESH_SEQUENTIAL_ENCODING
                                                              : draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(*mesh, &buffer).ok())
    throw std::runtime_error("draco encodes nothing");
  return {buffer.data(), buffer.size()};
}

GltfAndBin compressed(const GltfAndBin& plain, DracoMethod method, int bits, bool with_metadata) {
  Json root = base::parse_json<Json>(plain.gltf);
  GltfAndBin out;
  for (Json& mesh : root["meshes"]) {
    Json& primitive = mesh["primitives"][0];
    Json& accessor = root["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()];
    const auto number = accessor["bufferView"].get<std::size_t>();
    Json& view = root["bufferViews"][number];
    const std::string bytes =
        packed(std::string_view(plain.bin).substr(view["byteOffset"], view["byteLength"]), method,
               bits, with_metadata);
    view["byteOffset"] = out.bin.size();
    view["byteLength"] = bytes.size();
    out.bin += bytes;
    accessor.erase("bufferView");
    primitive["indices"] = root["accessors"].size();
    root["accessors"].push_back(
        {{"componentType", 5125}, {"count", accessor["count"]}, {"type", "SCALAR"}});
    primitive["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", number},
                                                             {"attributes", {{"POSITION", 0}}}};
  }
  while (out.bin.size() % 4 != 0) out.bin += '\0';
  root["buffers"][0]["byteLength"] = out.bin.size();
  root["extensionsUsed"] = root["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  out.gltf = base::dump_json(root);
  return out;
}

}  // namespace

GltfAndBin as_draco_gltf(const road::Mesh& mesh, const std::string& uri, DracoMethod method,
                         int bits, bool with_metadata) {
  return compressed(as_gltf(mesh, uri), method, bits, with_metadata);
}

std::string as_draco_glb(const road::Mesh& mesh, DracoMethod method, int bits, bool with_metadata) {
  GltfAndBin parts = as_draco_gltf(mesh, "", method, bits, with_metadata);
  Json root = base::parse_json<Json>(parts.gltf);
  root["buffers"][0].erase("uri");
  std::string json = base::dump_json(root);
  while (json.size() % 4 != 0) json += ' ';
  std::string bytes = "glTF";
  append(bytes, std::uint32_t{2});
  append(bytes, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + parts.bin.size()));
  append(bytes, static_cast<std::uint32_t>(json.size()));
  bytes += "JSON" + json;
  append(bytes, static_cast<std::uint32_t>(parts.bin.size()));
  return bytes + std::string("BIN\0", 4) + parts.bin;
}

}  // namespace support
