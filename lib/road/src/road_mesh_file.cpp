#include "road/road_mesh_file.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <string_view>

namespace road {
namespace {

constexpr const char* kNote = "drivable surface, metres, z up";

/// The note stands within the first bytes of all three formats.
bool is_cleaned(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<char, 200> head{};
  file.read(head.data(), head.size());
  const std::string_view seen(head.data(), static_cast<std::size_t>(file.gcount()));
  return seen.find(kNote) != std::string_view::npos;
}

/// Takes "kerb:" off the front of a name.
SurfaceClass take_class(std::string& name) {
  for (const SurfaceClass c : {SurfaceClass::road, SurfaceClass::kerb, SurfaceClass::runoff}) {
    const std::string prefix = std::string(to_string(c)) + ":";
    if (!name.starts_with(prefix)) continue;
    name.erase(0, prefix.size());
    return c;
  }
  return SurfaceClass::road;
}

/// .stl has no shared vertices; the stages after cleaning need them.
void share_equal_vertices(Mesh& mesh) {
  std::map<std::array<double, 3>, std::uint32_t> known;
  std::vector<std::uint32_t> new_index;
  std::vector<Eigen::Vector3d> kept;
  for (const Eigen::Vector3d& v : mesh.vertices_m) {
    const auto [at, is_new] =
        known.try_emplace({v.x(), v.y(), v.z()}, static_cast<std::uint32_t>(kept.size()));
    if (is_new) kept.push_back(v);
    new_index.push_back(at->second);
  }
  mesh.vertices_m = std::move(kept);
  for (auto& triangle : mesh.triangles)
    for (std::uint32_t& corner : triangle) corner = new_index[corner];
}

}  // namespace

void write_road_mesh(const RoadMesh& road, const std::string& path) {
  Mesh mesh = road.mesh;
  mesh.objects.clear();
  // One object per class and source object, in the order of the triangles.
  std::vector<std::array<std::uint32_t, 5>> number(
      road.mesh.objects.size() + 1, {UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX});
  mesh.object_of_triangle.resize(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::size_t source = road.mesh.object_of_triangle.empty()
                                   ? road.mesh.objects.size()
                                   : road.mesh.object_of_triangle[i];
    const auto c = static_cast<std::size_t>(road.class_of_triangle[i]);
    std::uint32_t& object = number[source][c];
    if (object == UINT32_MAX) {
      object = static_cast<std::uint32_t>(mesh.objects.size());
      MeshObject named =
          source < road.mesh.objects.size() ? road.mesh.objects[source] : MeshObject{};
      named.name = std::string(to_string(road.class_of_triangle[i])) + ":" + named.name;
      named.material.clear();
      mesh.objects.push_back(named);
    }
    mesh.object_of_triangle[i] = object;
  }
  write_mesh(mesh, path, kNote);
}

RoadMesh read_road_mesh(const Recipe& recipe) {
  if (!is_cleaned(recipe.mesh_path))
    return clean(read_mesh(recipe.mesh_path, recipe.read), recipe.clean);
  RoadMesh road;
  road.mesh = read_mesh(recipe.mesh_path, {UpAxis::z, Unit::m});
  share_equal_vertices(road.mesh);
  std::vector<SurfaceClass> class_of_object;
  for (MeshObject& object : road.mesh.objects) class_of_object.push_back(take_class(object.name));
  for (std::size_t i = 0; i < road.mesh.triangles.size(); ++i)
    road.class_of_triangle.push_back(road.mesh.object_of_triangle.empty()
                                         ? SurfaceClass::road
                                         : class_of_object[road.mesh.object_of_triangle[i]]);
  return road;
}

}  // namespace road
