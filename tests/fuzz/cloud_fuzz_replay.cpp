// Runs the cloud fuzz target over small clouds of every format and over mutations of them, so that
// ctest and any compiler exercise the readers. Arguments: number of mutations, first seed.
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "fuzz/cloud_fuzz.h"
#include "fuzz/mutated.h"
#include "support/cloud_files.h"

namespace {

struct Seed {
  std::string_view kind;
  std::string bytes;
};

std::vector<Seed> seeds() {
  const support::CloudSeed seed;
  std::vector<Seed> all;
  for (int format = 0; format <= 10; ++format)
    all.push_back(
        {"las", support::as_las(seed, format < 6 ? format % 4 : 4, format, format % 2 == 0)});
  for (const bool doubles : {false, true}) {
    for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"})
      all.push_back({"ply", support::as_cloud_ply(seed, format, doubles)});
    for (const char* data : {"ascii", "binary", "binary_compressed"})
      all.push_back({"pcd", support::as_pcd(seed, data, doubles)});
    all.push_back({"csv", support::as_xyz(seed, true)});
    all.push_back({"xyz", support::as_xyz(seed, false)});
  }
  all.push_back({"bin", support::as_kitti(seed)});
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t mutations = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 5000;
  const std::size_t first_seed = argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 1;
  const std::vector<Seed> all = seeds();
  for (const Seed& seed : all) cloud::fuzz::run(seed.kind, seed.bytes);
  for (std::size_t i = 0; i < mutations; ++i) {
    std::mt19937_64 generator(first_seed + i);
    const Seed& seed = all[i % all.size()];
    cloud::fuzz::run(seed.kind, ::fuzz::mutated(seed.bytes, generator, 400));
  }
  std::printf("%zu files\n", all.size() + mutations);
  return 0;
}
