// A person drives a unit of `crgsim serve` with a gamepad (docs/crgsim.md):
//   gamepad SOCKET [GEAR [GEARS]]
// SOCKET: the --socket of crgsim serve. GEAR: the one in which the car begins, 1 unless stated.
// GEARS: how many the car has, 6 unless stated.
#include <unistd.h>

#include <charconv>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string_view>

#include "drive.h"
#include "pads.h"

namespace {

bool read(std::string_view word, int& out) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), out);
  return error == std::errc() && end == word.data() + word.size();
}

}  // namespace

int main(int count, char** words) {
  gamepad::Gears gears;
  const bool is_read = count >= 2 && count <= 4 && (count < 3 || read(words[2], gears.first)) &&
                       (count < 4 || read(words[3], gears.count));
  if (!is_read || gears.count < 1 || gears.first < -1 || gears.first > gears.count) {
    std::fprintf(stderr,
                 "gamepad: wanted SOCKET [GEAR [GEARS]], a gear from -1 to the car's last\n");
    return 2;
  }
  try {
    gamepad::Pads pads;
    gamepad::drive(
        words[1], gears, [&] { return pads.look(); }, std::cout, ::isatty(STDOUT_FILENO) == 1);
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "gamepad: %s\n", failure.what());
    return 1;
  }
  return 0;
}
