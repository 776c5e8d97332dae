// Runs the cloud fuzz target over small clouds of every format and over mutations of them, so that
// ctest and any compiler exercise the readers. Arguments: number of mutations, first seed.
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "fuzz/cloud_fuzz.h"
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

/// A few damages, most of them in the first 400 bytes, where the headers are.
std::string mutated(std::string bytes, std::mt19937_64& generator) {
  constexpr const char* kNumbers[] = {
      "0",      "-1",   "1e30", "nan", "inf", "4294967296", "99999999999999999999",
      "1e-400", "-0.0", "7.25"};
  const auto below = [&](std::size_t limit) {
    return limit == 0 ? 0 : static_cast<std::size_t>(generator() % limit);
  };
  const std::size_t damages = 1 + below(4);
  for (std::size_t k = 0; k < damages && !bytes.empty(); ++k) {
    const std::size_t at =
        below(generator() % 3 == 0 ? bytes.size() : std::min<std::size_t>(bytes.size(), 400));
    const std::size_t length = 1 + below(std::min<std::size_t>(bytes.size() - at, 64));
    switch (below(8)) {
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
      case 6:
        for (std::size_t i = at; i < bytes.size() && i < at + 8; ++i)
          bytes[i] = static_cast<char>(generator() % 2 == 0 ? 0xff : 0);
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
  const std::size_t mutations = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 5000;
  const std::size_t first_seed = argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 1;
  const std::vector<Seed> all = seeds();
  for (const Seed& seed : all) cloud::fuzz::run(seed.kind, seed.bytes);
  for (std::size_t i = 0; i < mutations; ++i) {
    std::mt19937_64 generator(first_seed + i);
    const Seed& seed = all[i % all.size()];
    cloud::fuzz::run(seed.kind, mutated(seed.bytes, generator));
  }
  std::printf("%zu files\n", all.size() + mutations);
  return 0;
}
