// The surface that is driven on, as cleaning leaves it.
#pragma once

#include <optional>
#include <vector>

#include "mesh/mesh.h"
#include "road/guide.h"

namespace road {

/// The drivable surface: welded, faces turned up, class per triangle (road, kerb or runoff only).
struct RoadMesh {
  Mesh mesh;
  std::vector<SurfaceClass> class_of_triangle;
  std::optional<Guide> guide;  ///< along which it was found, where one or a route was given
};

}  // namespace road
