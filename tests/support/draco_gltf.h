// The small road as glTF compressed by Draco.
#pragma once

#include <string>

#include "mesh/mesh.h"
#include "support/mesh_files.h"

namespace support {

enum class DracoMethod { edgebreaker, sequential };

/// As as_gltf(), but every primitive is compressed, positions with `bits` bits; metadata goes along
/// if wanted.
GltfAndBin as_draco_gltf(const road::Mesh& mesh, const std::string& uri, DracoMethod method,
                         int bits, bool with_metadata = false);

/// The same in one file.
std::string as_draco_glb(const road::Mesh& mesh, DracoMethod method, int bits,
                         bool with_metadata = false);

}  // namespace support
