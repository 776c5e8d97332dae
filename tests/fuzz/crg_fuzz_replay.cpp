// Runs the fuzz target over files given on the command line (directories are walked), so that
// ctest replays the corpus without libFuzzer.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "fuzz/crg_fuzz.h"

int main(int argc, char** argv) {
  std::size_t count = 0;
  const auto replay = [&](const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    crg::fuzz::run(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    // Also cut short and with a byte flipped, at places spread over the file.
    for (std::size_t k = 1; k < 64; ++k) {
      std::vector<char> mutant = bytes;
      const std::size_t at = bytes.size() * k / 64;
      crg::fuzz::run(reinterpret_cast<const std::uint8_t*>(mutant.data()), at);
      if (at < mutant.size()) mutant[at] = static_cast<char>(mutant[at] ^ (1 << (k % 8)));
      crg::fuzz::run(reinterpret_cast<const std::uint8_t*>(mutant.data()), mutant.size());
    }
    ++count;
  };
  for (int k = 1; k < argc; ++k) {
    if (std::filesystem::is_directory(argv[k])) {
      for (const auto& entry : std::filesystem::recursive_directory_iterator(argv[k])) {
        if (entry.is_regular_file()) replay(entry.path());
      }
    } else {
      replay(argv[k]);
    }
  }
  std::printf("%zu files\n", count);
  return count > 0 ? 0 : 1;
}
