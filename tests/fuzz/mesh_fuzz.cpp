#include "fuzz/mesh_fuzz.h"

#include <filesystem>
#include <string>

#include "fuzz/target.h"
#include "mesh/error.h"
#include "mesh/read_mesh.h"
#include "road/clean.h"

namespace road::fuzz {
namespace {

using ::fuzz::require;

void check(const Mesh& mesh) {
  require(mesh.object_of_triangle.size() == mesh.triangles.size(), "an object for every triangle");
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    require(mesh.object_of_triangle[i] < mesh.objects.size(), "object in range");
    for (const std::uint32_t index : mesh.triangles[i]) {
      require(index < mesh.vertices_m.size(), "vertex in range");
      require(mesh.vertices_m[index].allFinite(), "finite coordinates");
    }
  }
}

}  // namespace

void run(std::string_view kind, std::string_view bytes) {
  const std::string path = ::fuzz::folder().put("mesh." + std::string(kind), bytes);
  try {
    MeshReadOptions options;
    options.own_process = false;
    const Mesh mesh = read_mesh(path, options);
    check(mesh);
    try {
      const RoadMesh road = clean(mesh);
      check(road.mesh);
      require(road.class_of_triangle.size() == road.mesh.triangles.size(),
              "a class for every triangle");
    } catch (const Error& error) {
      require(std::string_view(error.what()).size() > 20, "a sentence");
    }
  } catch (const Error& error) {
    require(std::string_view(error.what()).find(path) != std::string_view::npos,
            "the file's name in the error");
  }
  std::filesystem::remove(path);
}

}  // namespace road::fuzz
