// A glTF while its meshes are made plain: triangles that assimp reads as they lie. Private to the
// mesh readers.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "raw_mesh.h"

namespace road {

using GltfJson = nlohmann::json;

/// The numbers that glTF gives the types of components.
enum class GltfComponent : std::uint16_t {
  int8 = 5120,
  uint8 = 5121,
  int16 = 5122,
  uint16 = 5123,
  uint32 = 5125,
  float32 = 5126
};

/// Why a part of a glTF cannot be used; caught where that part has a name.
struct UnusableGltf : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The value of `key`, a whole number of at least 0. Throws UnusableGltf, or an exception of
/// GltfJson.
std::uint64_t gltf_whole(const GltfJson& object, const char* key);

/// The same, or 0 where there is no such key.
std::uint64_t gltf_whole_or_0(const GltfJson& object, const char* key);

class GltfFile {
 public:
  /// `bytes`: a .glb or the text of a .gltf, `path` names it; all shall outlive this.
  GltfFile(std::string_view bytes, const std::string& path, const BufferFile& buffer_file);

  /// No object where the text is no JSON.
  GltfJson& root() { return root_; }
  const GltfJson& root() const { return root_; }
  const std::string& path() const { return path_; }

  /// The bytes of a buffer view. Throws UnusableGltf, or an exception of GltfJson.
  std::string_view view(std::uint64_t number);

  /// Counts elements that a few bytes can declare, before memory is taken for them. Throws
  /// UnusableGltf where all so far are more than a file of this size can mean.
  void declare(std::uint64_t elements, std::string_view what);

  /// The number of a new accessor on new bytes, `count` elements of `type`.
  std::size_t add_accessor(std::string_view bytes, GltfComponent component, std::size_t count,
                           const char* type);

  /// The whole file as it is now. Throws Error.
  std::string written() const;

 private:
  std::string_view buffer(std::uint64_t number);

  std::string_view bytes_;
  const std::string& path_;
  const BufferFile& buffer_file_;
  std::string_view json_, binary_;  ///< the text and the binary chunk
  bool is_glb_ = false;
  GltfJson root_;
  std::map<std::uint64_t, std::string> buffers_;  ///< read already
  std::uint64_t size_;                            ///< bytes of the file and of the buffers read
  std::uint64_t declared_ = 0;
};

/// Numbers of an accessor as glTF stores float32 and uint32: `components` for each element, stored
/// in any way, sparse or nowhere (zeros). Throws UnusableGltf, or an exception of GltfJson.
std::vector<float> gltf_floats(GltfFile& file, std::uint64_t accessor, std::size_t components);
std::vector<std::uint32_t> gltf_indices(GltfFile& file, std::uint64_t accessor);

/// The type of the numbers of an accessor. Throws UnusableGltf, or an exception of GltfJson.
GltfComponent gltf_component(const GltfJson& accessor);

/// How far apart the numbers of an accessor of integers are at least.
double gltf_step(const GltfJson& accessor);

/// Whether a primitive is compressed by Draco.
bool has_draco(const GltfJson& primitive);

/// Puts plain positions and triangles in the place of those that Draco compressed. Throws
/// UnusableGltf, or an exception of GltfJson; damaged ones may crash it.
void unpack_draco(GltfFile& file, GltfJson& primitive);

}  // namespace road
