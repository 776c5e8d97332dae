// What a road was made from.
#pragma once

#include <string>

namespace road {

/// A file that went into the build.
struct InputFile {
  std::string role;  ///< "recipe", "mesh", "mesh_file" (what the mesh refers to), "control_points"
  std::string path;  ///< as the user gave it
  std::string sha256;  ///< 64 hex digits of its bytes; empty for a mesh_file that is missing
};

constexpr const char* kMeshFile = "mesh_file";

}  // namespace road
