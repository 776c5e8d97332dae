// Which axis of a mesh points up. Private to the mesh readers.
#pragma once

#include <string>
#include <vector>

#include "raw_mesh.h"

namespace road {

struct Up {
  UpAxis axis;
  std::string why;  ///< goes on after "up -z, ": "from the faces of 14,210 triangles"
};

/// What is told, checked against the line along which the large flat faces point. Not told: that
/// line, in the direction to which nearly all of them look; where they look both ways, and where
/// the file's format has this line as its own, in the format's. Adds remarks on contradictions.
/// Throws Error: told another line; UnknownUp: nothing tells.
Up decide_up(const RawMesh& mesh, UpAxis told, const std::string& path,
             std::vector<std::string>& remarks);

}  // namespace road
