// Draws the recordings of the blind trials: make_trials COUNT SEED DIR. Every trial gets a track, a
// stated car that is wrong by a few per cent everywhere, a recording of the truth, and a truth
// file.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "blind.h"
#include "scenarios.h"
#include "waves.h"

int main(int argc, char** argv) {
  if (argc == 4 && std::string(argv[1]) == "--scenario")
    return trials::make_scenario(argv[2], argv[3]) ? 0 : 1;
  const bool waves = argc == 5 && std::string(argv[1]) == "--waves";
  if (waves)
    ++argv;
  else if (argc != 4) {
    std::fprintf(stderr, "make_trials [--waves] COUNT SEED DIR\nmake_trials --scenario NAME DIR\n");
    return 2;
  }
  const auto draw = waves ? trials::draw_waves : trials::draw_blind;
  const int count = std::atoi(argv[1]);
  const auto seed = static_cast<unsigned long long>(std::atoll(argv[2]));
  const std::filesystem::path folder = argv[3];
  std::filesystem::create_directories(folder / "sealed");
  std::thread other([&] {
    for (int id = 1; id < count; id += 2) draw(id, seed, folder);
  });
  for (int id = 0; id < count; id += 2) draw(id, seed, folder);
  other.join();
  return 0;
}
