// Our own readers of mesh files, each on the same bytes: what comes before assimp, and in place of
// it.
#include <cmath>

#include "base/error.h"
#include "fuzz/target.h"
#include "raw_mesh.h"

namespace {

void check(const road::RawMesh& mesh) {
  fuzz::require(mesh.object_of_triangle.size() == mesh.triangles.size(), "an object per triangle");
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t index : triangle)
      fuzz::require(index < mesh.vertices.size(), "vertex in range");
  for (const std::uint32_t object : mesh.object_of_triangle)
    fuzz::require(object < mesh.objects.size(), "object in range");
}

template <class Reader>
void attempt(const Reader& read) {
  try {
    read();
  } catch (const base::Error& error) {
    fuzz::require_refusal(error, "input");
  }
}

}  // namespace

void fuzz::run(std::string_view bytes) {
  attempt([&] { check(road::read_stl(bytes, "input")); });
  attempt([&] { check(road::read_ply(bytes, "input")); });
  attempt([&] { (void)road::localise_ac3d(bytes, "input"); });
  // The list of materials is the mesh itself: its lines are as damaged as any.
  attempt([&] {
    const auto library = [&](const std::string&) { return std::optional<std::string>(bytes); };
    check(road::read_obj(bytes, "input", library));
  });
}
