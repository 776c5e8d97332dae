// Runs the mesh fuzz target over small meshes of every kind and over mutations of them, so that
// ctest exercises the readers without libFuzzer. Arguments: number of mutations of each kind, first
// seed.
#include <cstdio>
#include <cstdlib>
#include <random>

#include "fuzz/mesh_fuzz.h"
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
  return support::as_glb(mesh);
}

/// A few damages: bytes changed, parts cut out, repeated or moved, numbers made absurd.
std::string mutated(std::string bytes, std::mt19937_64& generator) {
  constexpr const char* kNumbers[] = {
      "0",      "-1",   "1e30", "nan", "inf", "4294967296", "99999999999999999999",
      "1e-400", "-0.0", "7.25"};
  const auto below = [&](std::size_t limit) {
    return limit == 0 ? 0 : static_cast<std::size_t>(generator() % limit);
  };
  const std::size_t damages = 1 + below(4);
  for (std::size_t k = 0; k < damages && !bytes.empty(); ++k) {
    const std::size_t at = below(bytes.size());
    const std::size_t length = 1 + below(std::min<std::size_t>(bytes.size() - at, 64));
    switch (below(7)) {
      case 0:
        bytes[at] = static_cast<char>(generator());
        break;
      case 1:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
        break;
      case 2:
        bytes.erase(at, length);
        break;
      case 3:
        bytes.insert(at, bytes.substr(at, length));
        break;
      case 4:
        bytes.resize(at);
        break;
      case 5:
        bytes.insert(below(bytes.size()), bytes.substr(at, length));
        break;
      default: {
        const std::size_t digit = bytes.find_first_of("0123456789", at);
        if (digit == std::string::npos) break;
        const std::size_t end = bytes.find_first_not_of("0123456789.eE+-", digit);
        bytes.replace(digit, (end == std::string::npos ? bytes.size() : end) - digit,
                      kNumbers[below(std::size(kNumbers))]);
      }
    }
  }
  return bytes;
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t mutations = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 200;
  const std::size_t first_seed = argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 1;
  std::size_t runs = 0;
  for (const std::string_view kind : road::fuzz::kKinds) {
    for (std::size_t variant = 0; variant < 6; ++variant) {
      road::fuzz::run(kind, seed_file(kind, variant));
      ++runs;
    }
    for (std::size_t i = 0; i < mutations; ++i) {
      std::mt19937_64 generator(first_seed + i);
      road::fuzz::run(kind, mutated(seed_file(kind, i), generator));
      ++runs;
    }
  }
  std::printf("%zu files\n", runs);
  return 0;
}
