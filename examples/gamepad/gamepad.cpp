// A person drives a unit of `crgsim serve` with a gamepad (docs/crgsim.md):
//   gamepad SOCKET [GEAR]
// SOCKET: the --socket of crgsim serve. GEAR: the one in which the car begins, 1 unless stated.
#include <unistd.h>

#include <charconv>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string_view>

#include "drive.h"
#include "pads.h"

int main(int count, char** words) {
  int gear = 1;
  const std::string_view said = count == 3 ? words[2] : "1";
  const auto [end, error] = std::from_chars(said.data(), said.data() + said.size(), gear);
  if ((count != 2 && count != 3) || error != std::errc() || end != said.data() + said.size() ||
      gear < -1 || gear > 6) {
    std::fprintf(stderr, "gamepad: wanted SOCKET [GEAR], a gear from -1 to 6\n");
    return 2;
  }
  try {
    gamepad::Pads pads;
    gamepad::drive(
        words[1], gear, [&] { return pads.look(); }, std::cout, ::isatty(STDOUT_FILENO) == 1);
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "gamepad: %s\n", failure.what());
    return 1;
  }
  return 0;
}
