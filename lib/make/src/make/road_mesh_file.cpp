#include "make/road_mesh_file.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <map>
#include <string_view>

#include "base/ending.h"
#include "base/read_file.h"

namespace road {
namespace {

constexpr const char* kNote = "drivable surface, metres, z up";

/// The note stands within the first bytes of all three formats.
bool is_cleaned(const std::string& path) {
  base::want_regular_file(path);
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

namespace {

/// Objects are the classes themselves: 0 road, 1 kerb, 2 run-off.
Mesh by_class(const RoadMesh& road) {
  Mesh mesh = road.mesh;
  mesh.objects = {{"road", "", ""}, {"kerb", "", ""}, {"runoff", "", ""}};
  mesh.object_of_triangle.clear();
  for (const SurfaceClass c : road.class_of_triangle)
    mesh.object_of_triangle.push_back(static_cast<std::uint32_t>(c));
  return mesh;
}

/// One object per class and source object, called "<class>:<name>".
Mesh by_class_and_name(const RoadMesh& road) {
  Mesh mesh = road.mesh;
  mesh.objects.clear();
  std::map<std::pair<std::uint32_t, SurfaceClass>, std::uint32_t> known;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const SurfaceClass c = road.class_of_triangle[i];
    const std::uint32_t source = road.mesh.object_of_triangle[i];
    const auto [at, is_new] =
        known.try_emplace({source, c}, static_cast<std::uint32_t>(mesh.objects.size()));
    if (is_new)
      mesh.objects.push_back(
          {std::string(to_string(c)) + ":" + road.mesh.objects[source].name, "", ""});
    mesh.object_of_triangle[i] = at->second;
  }
  return mesh;
}

/// The attributes that write_mesh() put into a binary .stl; empty when the file does not fit
/// `count`.
std::vector<SurfaceClass> stl_classes(const std::string& path, std::size_t count) {
  constexpr std::size_t kHead = 84, kTriangle = 50, kAttribute = 48;
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (bytes.size() != kHead + kTriangle * count) return {};
  std::vector<SurfaceClass> classes;
  for (std::size_t i = 0; i < count; ++i)
    classes.push_back(static_cast<SurfaceClass>(std::min(bytes[kHead + i * kTriangle + kAttribute],
                                                         static_cast<char>(SurfaceClass::runoff))));
  return classes;
}

using base::ending_of;

}  // namespace

void write_road_mesh(const RoadMesh& road, const std::string& path) {
  const std::string ending = ending_of(path);
  if ((ending == ".obj" || path == "-") && !road.mesh.object_of_triangle.empty())
    write_mesh(by_class_and_name(road), path, kNote);
  else if (ending == ".stl")
    write_mesh(by_class(road), path, kNote);
  else
    write_mesh(road.mesh, path);
}

RoadMesh read_road_mesh(const Recipe& recipe) {
  if (!is_cleaned(recipe.mesh_path))
    return clean(read_mesh(recipe.mesh_path, recipe.read), recipe.clean);
  RoadMesh road;
  road.guide = recipe.clean.guide;
  road.mesh = read_mesh(recipe.mesh_path, {UpAxis::z, Unit::m});
  share_equal_vertices(road.mesh);
  if (ending_of(recipe.mesh_path) == ".stl")
    road.class_of_triangle = stl_classes(recipe.mesh_path, road.mesh.triangles.size());
  std::vector<SurfaceClass> class_of_object;
  for (MeshObject& object : road.mesh.objects) class_of_object.push_back(take_class(object.name));
  if (road.class_of_triangle.empty())
    for (const std::uint32_t object : road.mesh.object_of_triangle)
      road.class_of_triangle.push_back(class_of_object.at(object));
  return road;
}

}  // namespace road
