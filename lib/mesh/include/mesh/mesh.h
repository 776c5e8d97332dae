// A triangle mesh in metres, z up, in a local frame.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

namespace road {

/// Red, green and blue in linear light, 0 to 1.
using LinearColour = std::array<float, 3>;

/// One object of the source file with one material, as the exporting program named them.
struct MeshObject {
  std::string name;  ///< empty where the format has no names
  std::string material;
  std::string texture;  ///< file name of the base texture
  /// Mean colour of its surface, where it was asked for (MeshReadOptions::want_colours) and is
  /// known: the mean of the base texture's pixels in linear light, by their opacity, times the
  /// material's base colour; without a texture that colour alone. White, and greys as light as
  /// exporters write where nobody chose one, are no base colour.
  std::optional<LinearColour> colour = {};
};
/// For base/archive.h.
template <class Archive, class Object>
requires std::is_same_v<std::remove_const_t<Object>, MeshObject>
void fields(Archive& archive, Object& o) { archive(o.name, o.material, o.texture, o.colour); }

/// What a wheel finds on it.
enum class SurfaceClass : std::uint8_t { road, kerb, runoff, barrier, scenery };
constexpr const char* to_string(SurfaceClass surface_class) {
  switch (surface_class) {
    case SurfaceClass::road:
      return "road";
    case SurfaceClass::kerb:
      return "kerb";
    case SurfaceClass::runoff:
      return "runoff";
    case SurfaceClass::barrier:
      return "barrier";
    case SurfaceClass::scenery:
      return "scenery";
  }
  return "?";
}

/// Triangles with shared or unshared vertices. Map position = origin_m + vertex.
/// The local frame keeps vertices small enough for float32 consumers (Embree).
struct Mesh {
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> vertices_m;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> object_of_triangle;  ///< index into objects; same length as triangles
  std::vector<MeshObject> objects;

  const Eigen::Vector3d& vertex(std::size_t triangle, int corner) const {
    return vertices_m[triangles[triangle][static_cast<std::size_t>(corner)]];
  }
};

}  // namespace road
