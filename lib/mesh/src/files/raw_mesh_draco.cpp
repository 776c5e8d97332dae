// glTF with meshes compressed by Draco (KHR_draco_mesh_compression). The library of Draco stays
// here.
#include <draco/compression/decode.h>
#include <draco/compression/point_cloud/point_cloud_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "base/one_line.h"
#include "mesh/error.h"
#include "raw_mesh.h"

namespace road {
namespace {

using Json = nlohmann::json;

constexpr const char* kExtension = "KHR_draco_mesh_compression";
// A flat grid of equal squares takes next to nothing; meshes as they are take a byte or more for
// each triangle. What a file declares beyond this, together, is refused before memory is taken for
// it.
constexpr std::uint64_t kTriangles = 1'000'000, kTrianglesPerByte = 20;
constexpr int kUnsignedInt = 5125, kFloat = 5126, kModeTriangles = 4;

/// The text and the binary chunk of a .glb, or a .gltf whole.
struct Gltf {
  std::string_view json, binary;
  bool is_glb = false;
};

std::uint32_t number_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

Gltf split(std::string_view bytes) {
  if (!bytes.starts_with("glTF") || bytes.size() < 20) return {bytes, {}, false};
  Gltf parts{bytes.substr(20, number_at(bytes, 12)), {}, true};
  const std::size_t next = 20 + parts.json.size();
  if (bytes.size() >= next + 8 && bytes.substr(next + 4, 4) == std::string_view("BIN\0", 4))
    parts.binary = bytes.substr(next + 8, number_at(bytes, next));
  return parts;
}

/// Three bytes as four characters, and back.
constexpr std::string_view kBase64 =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

std::string to_base64(std::string_view bytes) {
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text.push_back(i + k <= bytes.size() ? kBase64[three >> (18 - 6 * k) & 63u] : '=');
  }
  return text;
}

std::string from_base64(std::string_view text) {
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3);
  std::uint32_t held = 0;
  int bits = 0;
  for (const char c : text) {
    const std::size_t value = kBase64.find(c);
    if (value == std::string_view::npos) break;
    held = held << 6 | static_cast<std::uint32_t>(value);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes.push_back(static_cast<char>(held >> bits & 255u));
  }
  return bytes;
}

/// Triangles and vertices as glTF stores them: uint32 and three float32.
struct Decoded {
  std::string indices, positions;
  std::size_t corners = 0, vertices = 0;
  std::array<float, 3> lowest{}, highest{};
};

class DracoReader {
 public:
  DracoReader(std::string_view bytes, const std::string& path, const BufferFile& buffer_file)
      : bytes_(bytes), path_(path), buffer_file_(buffer_file), parts_(split(bytes)) {}

  std::optional<std::string> read() {
    if (parts_.json.find(kExtension) == std::string_view::npos) return std::nullopt;
    root_ = Json::parse(parts_.json, nullptr, false);
    if (root_.is_discarded()) {  // names in other encodings than UTF-8
      std::string ascii(parts_.json);
      std::replace_if(
          ascii.begin(), ascii.end(), [](char c) { return static_cast<unsigned char>(c) >= 0x80; },
          '?');
      root_ = Json::parse(ascii, nullptr, false);
    }
    if (!root_.is_object() || !root_["meshes"].is_array()) return std::nullopt;
    for (std::size_t m = 0; m < root_["meshes"].size(); ++m) {
      if (!root_["meshes"][m].is_object()) continue;
      const auto primitives = root_["meshes"][m].find("primitives");
      if (primitives == root_["meshes"][m].end() || !primitives->is_array()) continue;
      for (Json& primitive : *primitives) {
        try {
          unpack(primitive);
        } catch (const Json::exception& error) {
          fail(m, error.what());
        } catch (const Unusable& error) {
          fail(m, error.what());
        } catch (const std::length_error&) {
          fail(m, "damaged data of Draco");
        }
      }
    }
    if (!found_) return std::nullopt;
    for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
      const auto names = root_.find(list);
      if (names != root_.end() && names->is_array())
        std::erase(names->get_ref<Json::array_t&>(), kExtension);
      if (names != root_.end() && names->empty())
        root_.erase(names);  // the standard allows no empty one
    }
    return written();
  }

 private:
  [[noreturn]] void fail(std::size_t mesh, const std::string& why) const {
    throw Error(fmt::format(
        "{}: mesh {} is compressed by Draco and cannot be read: {}; export it again, or "
        "without compression",
        path_, mesh, base::one_line(why)));
  }
  /// Caught where the mesh is known.
  struct Unusable : std::runtime_error {
    using std::runtime_error::runtime_error;
  };
  [[noreturn]] static void refuse(const std::string& why) { throw Unusable(why); }

  static std::uint64_t whole(const Json& object, const char* key) {
    const Json& value = object.at(key);
    if (!value.is_number_unsigned()) refuse(fmt::format("'{}' is no whole number", key));
    return value.get<std::uint64_t>();
  }

  /// The bytes of a buffer of the file.
  std::string_view buffer(std::uint64_t number) {
    const Json& object = root_.at("buffers").at(number);
    const auto uri = object.find("uri");
    if (uri == object.end()) {
      if (number != 0 || !parts_.is_glb) refuse(fmt::format("buffer {} has no bytes", number));
      return parts_.binary;
    }
    const auto [known, is_new] = buffers_.try_emplace(number);
    if (!is_new) return known->second;
    const auto& text = uri->get_ref<const std::string&>();
    const std::size_t comma = text.starts_with("data:") ? text.find(";base64,") : std::string::npos;
    if (comma != std::string::npos) {
      known->second = from_base64(std::string_view(text).substr(comma + 8));
    } else if (auto content = buffer_file_(text)) {
      known->second = std::move(*content);
    } else {
      refuse(fmt::format("buffer '{}' is not read", text.substr(0, 60)));
    }
    return known->second;
  }

  std::string_view view(std::uint64_t number) {
    const Json& object = root_.at("bufferViews").at(number);
    const std::string_view bytes = buffer(whole(object, "buffer"));
    const std::uint64_t begin = object.contains("byteOffset") ? whole(object, "byteOffset") : 0;
    const std::uint64_t length = whole(object, "byteLength");
    if (begin > bytes.size() || length > bytes.size() - begin)
      refuse(fmt::format("bytes {} to {} of a buffer of {}", begin, begin + length, bytes.size()));
    return bytes.substr(begin, length);
  }

  /// What the head of the compressed bytes declares, before draco takes memory for it.
  void check_declared(std::string_view packed) {
    draco::DecoderBuffer buffer;
    buffer.Init(packed.data(), packed.size());
    draco::DracoHeader header{};
    if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok()) refuse("no data of Draco");
    if (header.version_major != 2 || header.version_minor != 2)
      refuse(fmt::format("version {}.{} of Draco; wanted 2.2", header.version_major,
                         header.version_minor));
    if (header.encoder_type != draco::TRIANGULAR_MESH) refuse("points without triangles");
    buffer.set_bitstream_version(DRACO_BITSTREAM_VERSION(2, 2));
    if ((header.flags & METADATA_FLAG_MASK) != 0) {
      draco::GeometryMetadata metadata;
      if (!draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &metadata))
        refuse("damaged metadata");
    }
    std::uint8_t traversal = 0;
    std::uint32_t first = 0, second = 0;  // faces and points, or vertices and faces
    const bool is_sequential = header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING;
    if ((!is_sequential && !buffer.Decode(&traversal)) || !draco::DecodeVarint(&first, &buffer) ||
        !draco::DecodeVarint(&second, &buffer))
      refuse("data of Draco that end in their head");
    declared_ += std::max<std::uint64_t>(first, second);
    if (declared_ > kTriangles + kTrianglesPerByte * bytes_.size()) {
      refuse(fmt::format("{} triangles or vertices are declared, too many for a file of {} bytes",
                         declared_, bytes_.size()));
    }
  }

  Decoded decode(std::string_view packed, std::uint64_t positions_id) {
    check_declared(packed);
    draco::DecoderBuffer buffer;
    buffer.Init(packed.data(), packed.size());
    draco::Decoder decoder;
    auto result = decoder.DecodeMeshFromBuffer(&buffer);
    if (!result.ok()) refuse("damaged data of Draco");
    const std::unique_ptr<draco::Mesh> mesh = std::move(result).value();
    const draco::PointAttribute* positions =
        mesh ? mesh->GetAttributeByUniqueId(static_cast<std::uint32_t>(positions_id)) : nullptr;
    if (positions == nullptr || positions->num_components() != 3)
      refuse("no positions in the data of Draco");
    Decoded out;
    out.vertices = mesh->num_points();
    if (!positions->is_mapping_identity() && positions->indices_map_size() < out.vertices)
      refuse("vertices without positions");
    out.lowest.fill(std::numeric_limits<float>::infinity());
    out.highest.fill(-std::numeric_limits<float>::infinity());
    for (draco::PointIndex p(0); p < mesh->num_points(); ++p) {
      std::array<float, 3> v{};
      if (!positions->ConvertValue<float, 3>(positions->mapped_index(p), v.data()))
        refuse("vertices without positions");
      for (std::size_t k = 0; k < 3; ++k) {
        out.lowest[k] = std::min(out.lowest[k], v[k]);
        out.highest[k] = std::max(out.highest[k], v[k]);
      }
      out.positions.append(reinterpret_cast<const char*>(v.data()), sizeof v);
    }
    for (draco::FaceIndex f(0); f < mesh->num_faces(); ++f) {
      for (const draco::PointIndex& corner : mesh->face(f)) {
        const std::uint32_t index = corner.value();
        if (index >= out.vertices) refuse("a triangle of vertices that are not there");
        out.indices.append(reinterpret_cast<const char*>(&index), sizeof index);
      }
    }
    out.corners = std::size_t{3} * mesh->num_faces();
    return out;
  }

  /// The number of a new accessor on new bytes.
  std::size_t add_accessor(const std::string& bytes, Json accessor) {
    Json &buffers = root_["buffers"], &views = root_["bufferViews"],
         &accessors = root_["accessors"];
    views.push_back({{"buffer", buffers.size()}, {"byteLength", bytes.size()}});
    buffers.push_back({{"byteLength", bytes.size()},
                       {"uri", "data:application/octet-stream;base64," + to_base64(bytes)}});
    accessor["bufferView"] = views.size() - 1;
    accessors.push_back(std::move(accessor));
    return accessors.size() - 1;
  }

  void unpack(Json& primitive) {
    if (!primitive.is_object() || !primitive.contains("extensions") ||
        !primitive["extensions"].contains(kExtension))
      return;
    found_ = true;
    const Json& packed = primitive["extensions"][kExtension];
    const Decoded mesh =
        decode(view(whole(packed, "bufferView")), whole(packed.at("attributes"), "POSITION"));
    // Normals and places on textures go: nobody asks for them.
    primitive.erase("targets");
    primitive["mode"] = kModeTriangles;
    primitive["extensions"].erase(kExtension);
    primitive["attributes"] = Json::object();
    if (mesh.corners == 0 || mesh.vertices == 0) refuse("it has no triangles");
    primitive["attributes"]["POSITION"] = add_accessor(mesh.positions, {{"componentType", kFloat},
                                                                        {"count", mesh.vertices},
                                                                        {"type", "VEC3"},
                                                                        {"min", mesh.lowest},
                                                                        {"max", mesh.highest}});
    primitive["indices"] = add_accessor(
        mesh.indices,
        {{"componentType", kUnsignedInt}, {"count", mesh.corners}, {"type", "SCALAR"}});
  }

  std::string written() const {
    std::string json = root_.dump(-1, ' ', false, Json::error_handler_t::replace);
    if (!parts_.is_glb) return json;
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::size_t size =
        20 + json.size() + (parts_.binary.empty() ? 0 : 8 + parts_.binary.size());
    if (size > std::numeric_limits<std::uint32_t>::max())
      throw Error(fmt::format(
          "{}: without the compression by Draco it has more than 4 GB; reduce the mesh", path_));
    std::string out = "glTF";
    const auto put = [&](std::size_t value) {
      const auto number = static_cast<std::uint32_t>(value);
      out.append(reinterpret_cast<const char*>(&number), sizeof number);
    };
    put(2), put(size), put(json.size());
    out += "JSON" + json;
    if (!parts_.binary.empty()) {
      put(parts_.binary.size());
      out += std::string_view("BIN\0", 4);
      out += parts_.binary;
    }
    return out;
  }

  std::string_view bytes_;
  const std::string& path_;
  const BufferFile& buffer_file_;
  Gltf parts_;
  Json root_;
  std::map<std::uint64_t, std::string> buffers_;  ///< read already
  std::uint64_t declared_ = 0;                    ///< triangles of all meshes so far
  bool found_ = false;
};

}  // namespace

std::optional<std::string> without_draco(std::string_view bytes, const std::string& path,
                                         const BufferFile& buffer_file) {
  return DracoReader(bytes, path, buffer_file).read();
}

}  // namespace road
