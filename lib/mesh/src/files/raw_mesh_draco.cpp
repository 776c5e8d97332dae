// glTF with meshes compressed by Draco (KHR_draco_mesh_compression). The library of Draco stays
// here.
#include <draco/compression/decode.h>
#include <draco/compression/point_cloud/point_cloud_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <stdexcept>
#include <utility>

#include "gltf_file.h"

namespace road {
namespace {

constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr int kModeTriangles = 4;

/// Triangles and vertices as glTF stores them: uint32 and three float32.
struct Decoded {
  std::string indices, positions;
  std::size_t corners = 0, vertices = 0;
};

[[noreturn]] void refuse_draco(const std::string& why) { throw UnusableGltf(why); }

/// What the head of the compressed bytes declares, before draco takes memory for it.
void check_declared(std::string_view packed, GltfFile& file) {
  draco::DecoderBuffer buffer;
  buffer.Init(packed.data(), packed.size());
  draco::DracoHeader header{};
  if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok())
    refuse_draco("no data of Draco");
  if (header.version_major != 2 || header.version_minor != 2)
    refuse_draco(fmt::format("version {}.{} of Draco; wanted 2.2", header.version_major,
                             header.version_minor));
  if (header.encoder_type != draco::TRIANGULAR_MESH) refuse_draco("points without triangles");
  buffer.set_bitstream_version(DRACO_BITSTREAM_VERSION(2, 2));
  if ((header.flags & METADATA_FLAG_MASK) != 0) {
    draco::GeometryMetadata metadata;
    if (!draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &metadata))
      refuse_draco("damaged metadata");
  }
  std::uint8_t traversal = 0;
  std::uint32_t first = 0, second = 0;  // faces and points, or vertices and faces
  const bool is_sequential = header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING;
  if ((!is_sequential && !buffer.Decode(&traversal)) || !draco::DecodeVarint(&first, &buffer) ||
      !draco::DecodeVarint(&second, &buffer))
    refuse_draco("data of Draco that end in their head");
  file.declare(std::max(first, second), "triangles or vertices");
}

Decoded decode(std::string_view packed, std::uint64_t positions_id, GltfFile& file) {
  check_declared(packed, file);
  draco::DecoderBuffer buffer;
  buffer.Init(packed.data(), packed.size());
  draco::Decoder decoder;
  auto result = decoder.DecodeMeshFromBuffer(&buffer);
  if (!result.ok()) refuse_draco("damaged data of Draco");
  const std::unique_ptr<draco::Mesh> mesh = std::move(result).value();
  const draco::PointAttribute* positions =
      mesh ? mesh->GetAttributeByUniqueId(static_cast<std::uint32_t>(positions_id)) : nullptr;
  if (positions == nullptr || positions->num_components() != 3)
    refuse_draco("no positions in the data of Draco");
  Decoded out;
  out.vertices = mesh->num_points();
  if (!positions->is_mapping_identity() && positions->indices_map_size() < out.vertices)
    refuse_draco("vertices without positions");
  for (draco::PointIndex p(0); p < mesh->num_points(); ++p) {
    std::array<float, 3> v{};
    if (!positions->ConvertValue<float, 3>(positions->mapped_index(p), v.data()))
      refuse_draco("vertices without positions");
    out.positions.append(reinterpret_cast<const char*>(v.data()), sizeof v);
  }
  for (draco::FaceIndex f(0); f < mesh->num_faces(); ++f) {
    for (const draco::PointIndex& corner : mesh->face(f)) {
      const std::uint32_t index = corner.value();
      if (index >= out.vertices) refuse_draco("a triangle of vertices that are not there");
      out.indices.append(reinterpret_cast<const char*>(&index), sizeof index);
    }
  }
  out.corners = std::size_t{3} * mesh->num_faces();
  return out;
}

}  // namespace

bool has_draco(const GltfJson& primitive) {
  const auto extensions = primitive.find("extensions");
  return extensions != primitive.end() && extensions->contains(kDraco);
}

void unpack_draco(GltfFile& file, GltfJson& primitive) {
  const GltfJson packed = primitive.at("extensions").at(kDraco);
  const Decoded mesh = [&] {
    try {
      return decode(file.view(gltf_whole(packed, "bufferView")),
                    gltf_whole(packed.at("attributes"), "POSITION"), file);
    } catch (const std::length_error&) {
      refuse_draco("damaged data of Draco");
    }
  }();
  // Normals and places on textures go: nobody asks for them.
  primitive.erase("targets");
  primitive["mode"] = kModeTriangles;
  primitive["extensions"].erase(kDraco);
  primitive["attributes"] = GltfJson::object();
  if (mesh.corners == 0 || mesh.vertices == 0) refuse_draco("it has no triangles");
  primitive["attributes"]["POSITION"] =
      file.add_accessor(mesh.positions, GltfComponent::float32, mesh.vertices, "VEC3");
  primitive["indices"] =
      file.add_accessor(mesh.indices, GltfComponent::uint32, mesh.corners, "SCALAR");
}

}  // namespace road
