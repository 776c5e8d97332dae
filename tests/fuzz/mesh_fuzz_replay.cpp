// Runs the mesh fuzz target over small meshes of every kind and over mutations of them, so that
// ctest exercises the readers without libFuzzer. Arguments: number of mutations of each kind, ten
// times as many with KERBSTONE_HEAVY=1; first seed.
#include <cstdio>
#include <cstdlib>
#include <random>

#include "fuzz/mesh_fuzz.h"
#include "fuzz/mutated.h"
#include "support/gltf_parts.h"
#include "support/mesh_files.h"

namespace {

std::string seed_file(std::string_view kind, std::size_t variant) {
  const road::Mesh mesh = support::small_road();
  if (kind == "stl") return variant % 2 == 0 ? support::as_stl(mesh) : support::as_text_stl(mesh);
  if (kind == "ply") {
    constexpr const char* kFormats[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    return support::as_ply(mesh, kFormats[variant % 3], variant % 2 == 0 ? "float" : "double");
  }
  if (kind == "obj") return support::as_obj(mesh, variant % 2 == 0 ? 'z' : 'y');
  if (kind == "acc") return support::as_acc(mesh);
  return variant % 2 == 0 ? support::as_glb(mesh) : support::busy_gltf().glb();
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t mutations = (argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 20) *
                                (std::getenv("KERBSTONE_HEAVY") != nullptr ? 10 : 1);
  const std::size_t first_seed = argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 1;
  std::size_t runs = 0;
  for (const std::string_view kind : road::fuzz::kKinds) {
    for (std::size_t variant = 0; variant < 6; ++variant) {
      road::fuzz::run(kind, seed_file(kind, variant));
      ++runs;
    }
    for (std::size_t i = 0; i < mutations; ++i) {
      std::mt19937_64 generator(first_seed + i);
      road::fuzz::run(kind, ::fuzz::mutated(seed_file(kind, i), generator));
      ++runs;
    }
  }
  std::printf("%zu files\n", runs);
  return 0;
}
