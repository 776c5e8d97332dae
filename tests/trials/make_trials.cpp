// Draws the recordings of the blind trials: make_trials COUNT SEED DIR. Every trial gets a track, a
// stated car that is wrong by a few per cent everywhere, a recording of the truth, and a truth
// file. --third-share S: so many of the trials are the third car's. --scenario: a named one, with
// so many laps in place of its own. --fleet: several cars on one road.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>

#include "blind.h"
#include "fleet.h"
#include "scenarios.h"
#include "waves.h"

int main(int argc, char** argv) {
  if ((argc == 4 || argc == 5) && std::string(argv[1]) == "--scenario")
    return trials::make_scenario(argv[2], argv[3], argc == 5 ? std::atoi(argv[4]) : 0) ? 0 : 1;
  if (argc == 7 && std::string(argv[1]) == "--fleet")
    return trials::make_fleet(argv[2], std::atoi(argv[3]), std::atoi(argv[4]),
                              static_cast<unsigned long long>(std::atoll(argv[5])), argv[6])
               ? 0
               : 1;
  bool waves = false;
  double third_share = 1.0 / 3;
  for (; argc > 4 && std::string(argv[1]).starts_with("--"); --argc, ++argv) {
    const std::string option = argv[1];
    char* end = nullptr;
    if (option == "--waves") {
      waves = true;
    } else if (option == "--third-share" && argc > 5) {
      third_share = std::strtod(argv[2], &end);
      if (*end != '\0' || !(third_share >= 0 && third_share <= 1)) break;
      --argc, ++argv;
    } else {
      break;
    }
  }
  if (argc != 4) {
    std::fprintf(
        stderr,
        "make_trials [--waves | --third-share 0..1] COUNT SEED DIR\nmake_trials --scenario "
        "NAME DIR [LAPS]\nmake_trials --fleet NAME CARS LAPS SEED DIR\n");
    return 2;
  }
  const int count = std::atoi(argv[1]);
  const auto seed = static_cast<unsigned long long>(std::atoll(argv[2]));
  const std::filesystem::path folder = argv[3];
  std::filesystem::create_directories(folder / "sealed");
  const auto draw = [&](int id) {
    if (waves)
      trials::draw_waves(id, seed, folder);
    else
      trials::draw_blind(id, seed, third_share, folder);
  };
  std::thread other([&] {
    for (int id = 1; id < count; id += 2) draw(id);
  });
  for (int id = 0; id < count; id += 2) draw(id);
  other.join();
  return 0;
}
