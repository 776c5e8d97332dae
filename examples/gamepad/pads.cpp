#include "pads.h"

#define SDL_MAIN_HANDLED
#include <SDL.h>

#include <algorithm>
#include <stdexcept>
#include <string>

namespace gamepad {

Pads::Pads() {
  SDL_SetMainReady();
  SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");                // Ctrl-C ends the program
  SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");  // there is no window
  if (SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER) != 0)
    throw std::runtime_error(std::string("gamepads: ") + SDL_GetError());
}

Pads::~Pads() {
  if (pad_ != nullptr) SDL_GameControllerClose(pad_);
  SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);
}

std::optional<Said> Pads::look() {
  Said said;
  SDL_Event event;
  while (SDL_PollEvent(&event) != 0) {
    if (event.type != SDL_CONTROLLERBUTTONDOWN) continue;
    const auto button = event.cbutton.button;
    said.shifts += button == SDL_CONTROLLER_BUTTON_RIGHTSHOULDER ? 1 : 0;
    said.shifts -= button == SDL_CONTROLLER_BUTTON_LEFTSHOULDER ? 1 : 0;
    said.again = said.again || button == SDL_CONTROLLER_BUTTON_START;
    said.ends = said.ends || button == SDL_CONTROLLER_BUTTON_BACK;
  }
  if (pad_ != nullptr && SDL_GameControllerGetAttached(pad_) == SDL_FALSE) {
    SDL_GameControllerClose(pad_);
    pad_ = nullptr;
  }
  for (int i = 0; pad_ == nullptr && i < SDL_NumJoysticks(); ++i)
    if (SDL_IsGameController(i) == SDL_TRUE) pad_ = SDL_GameControllerOpen(i);
  if (pad_ == nullptr) return std::nullopt;
  const auto way = [&](SDL_GameControllerAxis axis) {
    return std::max(-1.0, SDL_GameControllerGetAxis(pad_, axis) / 32767.0);
  };
  said.stick = way(SDL_CONTROLLER_AXIS_LEFTX);
  said.throttle = way(SDL_CONTROLLER_AXIS_TRIGGERRIGHT);
  said.brake = way(SDL_CONTROLLER_AXIS_TRIGGERLEFT);
  return said;
}

}  // namespace gamepad
