// A track mesh to look at: fewer triangles, each told what cleaning takes it for.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "make/recipe.h"
#include "mesh/mesh.h"

namespace road {

/// Triangles of one object that cleaning takes for the same thing.
struct PreviewPart {
  std::size_t object = 0;          ///< index into Mesh::objects
  std::string surface_class;       ///< "road", "kerb", ...; "unknown" without cleaning, and where
                                   ///< it refused the mesh
  std::size_t triangles = 0;       ///< in the mesh
  double area_m2 = 0.0;            ///< in the mesh
  std::vector<float> positions_m;  ///< x, y, z after one another; plus the origin: map position
  std::vector<std::uint32_t> indices;  ///< three per triangle that is left
};

struct Preview {
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
  std::vector<MeshObject> objects;
  std::vector<PreviewPart> parts;  ///< by object, then by class
  std::size_t triangles_in = 0, triangles_shown = 0;
  std::string up, unit;
  std::string told_by;  ///< as told_by() of cleaning has it; empty where refused or not asked for
  std::string refusal;  ///< why cleaning refused the mesh; empty where it did not
  std::vector<std::string> remarks;  ///< of reading and cleaning
};

constexpr std::size_t kPreviewTriangles = 400'000;

enum class PreviewClasses {
  cleaned,  ///< what cleaning takes each triangle for
  none      ///< "unknown" for all, without cleaning, thinned by cells: a tenth of the time
};

/// Reads and cleans the recipe's mesh. A mesh of more than `most` triangles is thinned, every part
/// by the same share (meshoptimizer stays private to the source file); parts never vanish. Throws
/// Error when the mesh cannot be read; a mesh that cleaning refuses is shown all the same.
Preview preview(const Recipe& recipe, std::size_t most = kPreviewTriangles,
                PreviewClasses classes = PreviewClasses::cleaned);

/// The bytes of a .glb: y up as glTF wants it, a node per part in the colour of its class. What
/// Preview holds besides stands in `extras` of the scene and of the nodes; there, and in the
/// buffers, z is up.
std::string glb_of(const Preview& preview);

}  // namespace road
