// What a mesh file holds, before axis, unit and origin are decided. Private to the mesh readers.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/mesh.h"
#include "mesh/read_mesh.h"

namespace road {

/// What a material says of the colour of its objects, before pictures are read.
struct BaseLook {
  std::string picture;                 ///< as the file names it, folders and all; empty: none
  std::optional<LinearColour> colour;  ///< nothing: not stated, or nobody's choice
};

/// A stated colour, unless it is white or as light a grey as exporters write where nobody chose
/// one. `is_linear`: else it is coded as sRGB.
std::optional<LinearColour> base_colour(const std::array<double, 3>& stated, bool is_linear);

/// Triangles in the file's own axes and unit, absolute coordinates in double.
struct RawMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> object_of_triangle;
  std::vector<MeshObject> objects;
  std::vector<BaseLook> looks;                ///< until the colours are put
  std::vector<std::uint32_t> look_of_object;  ///< index into looks; empty where there are none
  bool stored_as_float32 = false;  ///< the coordinates went through float32 inside the file
  double local_magnitude =
      0.0;  ///< |coordinate| that float32 had to carry, typical (centre of the box)
  double metres_per_unit = 0.0;   ///< as the file states; 0 = it does not
  UpAxis up = UpAxis::automatic;  ///< by the format's rule or the file's word; automatic = neither
  bool left_handed = false;       ///< by the file's word
  std::vector<std::string> remarks;
  std::vector<MeshFile> files;  ///< as in MeshReadReport
};

/// `bytes` is the whole file, `path` names it in errors. Throws Error.
RawMesh read_stl(std::string_view bytes, const std::string& path);
RawMesh read_ply(std::string_view bytes, const std::string& path);

/// A mesh of 100 million triangles, or the buffer of one, in the most wasteful format.
constexpr std::size_t kLargestMeshFile = 16'000'000'000;

/// Refuses what would make a reader that calls itself for every level run out of stack, or visit
/// shared parts without end: nested glTF, XML and text in braces. What is no such format, or
/// damaged otherwise, passes. Throws Error.
void check_nesting(std::string_view bytes, const std::string& path);

/// What an .obj calls a list of materials (.mtl) -> its text; nothing where it cannot be had.
using MaterialLibrary = std::function<std::optional<std::string>(const std::string& name)>;

/// Wavefront .obj. What the last 'o' or 'g' line says is an object's name; objects and materials
/// that come again go on where they stopped. Throws Error, also where cutting large polygons would
/// take minutes.
RawMesh read_obj(std::string_view bytes, const std::string& path, const MaterialLibrary& library);

/// The same, with lists of materials that lie where the mesh may refer to (see read_with_assimp).
RawMesh read_obj_file(std::string_view bytes, const std::string& path,
                      const MeshReadOptions& options,
                      const std::function<void(std::size_t)>& opened);

/// Cuts a polygon into triangles by ears; points and lines give none. assimp's own step for this
/// ends the program on some damaged files. Gives how many corners were asked whether they lie in an
/// ear: some 20 ns each; of 2,000 corners seen: up to 4e6.
std::size_t triangulate(const std::vector<Eigen::Vector3d>& vertices,
                        std::vector<std::uint32_t>& polygon,
                        std::vector<std::array<std::uint32_t, 3>>& triangles);

/// What a glTF calls a buffer -> its bytes; nothing where they cannot be had.
using BufferFile = std::function<std::optional<std::string>(const std::string& uri)>;

/// What assimp does not know of a node of glTF.
struct NodePlacement {
  /// Where its mesh is shown, in its frame (EXT_mesh_gpu_instancing).
  std::vector<Eigen::Matrix4d> instances = {Eigen::Matrix4d::Identity()};
  double step = 0.0;  ///< of the coordinates of its mesh, before it is placed; 0: of float32
};

struct PlainGltf {
  std::string bytes;
  std::vector<NodePlacement> placements;  ///< of nodes whose names take_placement() knows
};

/// A glTF or .glb with float32 positions that lie in its buffers where it has others: compressed by
/// Draco, integers (KHR_mesh_quantization) or sparse. Nothing where assimp reads it as it is.
/// Throws Error: it requires an extension that is not read, is damaged, or declares far more than
/// so many bytes can hold. Files with damaged data of Draco may crash it.
std::optional<PlainGltf> plain_gltf(std::string_view bytes, const std::string& path,
                                    const BufferFile& buffer_file);

/// The placement that belongs to the name of a node, or nullptr. The name becomes that of the file.
const NodePlacement* take_placement(const std::vector<NodePlacement>& placements,
                                    std::string& name);

/// Any other format. Files that the mesh refers to are read only below its folder unless
/// the options say otherwise: one with geometry refuses the mesh, one for looks is a remark. Calls
/// `opened` with the size of each. Throws Error; damaged files may crash it.
RawMesh read_with_assimp(std::string_view bytes, const std::string& path,
                         const Eigen::Vector3d& origin, const MeshReadOptions& options,
                         const std::function<void(std::size_t)>& opened);

/// Runs `read` in a child of this process and gives what it gives or throws; its crash, or its
/// taking far more memory or time than `bytes` (and those that it tells `opened`) can need, is an
/// Error that names `path`. The other threads of this process do not run in the child.
RawMesh read_in_child(
    const std::string& path, std::size_t bytes,
    const std::function<RawMesh(const std::function<void(std::size_t)>& opened)>& read);

/// Text that assimp reads without loss: coordinates relative to `origin`.
struct LocalText {
  std::string text;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  bool float32_quantised =
      false;  ///< every coordinate is a float32 number although the text could carry more
  std::vector<std::string> remarks;
};

/// AC3D (.ac, .acc): checks that the file is complete and drops every texture line but the base one
/// (the last line would win in assimp, which then loses the object's texture).
LocalText localise_ac3d(std::string_view bytes, const std::string& path);

/// An origin worth subtracting, or zero: coordinates beyond 1,000 units lose 0.1 mm in float32.
Eigen::Vector3d local_origin(const Eigen::Vector3d& lowest, const Eigen::Vector3d& highest);

}  // namespace road
