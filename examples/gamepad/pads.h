// The first gamepad that SDL knows.
#pragma once

#include <optional>

#include "drive.h"

struct _SDL_GameController;

namespace gamepad {

class Pads {
 public:
  Pads();  ///< throws std::runtime_error, as SDL says
  Pads(const Pads&) = delete;
  Pads& operator=(const Pads&) = delete;
  ~Pads();

  /// Left stick, triggers; right and left shoulder shift, start begins again, back ends. Nothing
  /// where no pad is plugged in; whichever is plugged in later is taken.
  std::optional<Said> look();

 private:
  _SDL_GameController* pad_ = nullptr;
};

}  // namespace gamepad
