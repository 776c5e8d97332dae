#include "fuzz/mesh_fuzz.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "road/clean.h"
#include "road/error.h"
#include "road/read_mesh.h"

namespace road::fuzz {
namespace {

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "mesh fuzz: %s\n", what);
  std::abort();
}

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
  static const std::string folder = [] {
    std::string name =
        (std::filesystem::temp_directory_path() / "kerbstone_mesh_fuzz.XXXXXX").string();
    require(::mkdtemp(name.data()) != nullptr, "a temporary folder");
    return name;
  }();
  const std::string path = folder + "/mesh." + std::string(kind);
  std::ofstream(path, std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
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
