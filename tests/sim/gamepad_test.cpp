// The example by which a person drives with a gamepad: its mapping, and a virtual pad of SDL in the
// place of a real one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>
#include <sstream>
#include <thread>

#include "gamepad/drive.h"
#include "sim/serve_unit.h"
#include "some_unit.h"
#include "support/places.h"
#include "support/run_tool.h"
#include "support/temporary_folder.h"

#ifdef EXAMPLE_GAMEPAD
#define SDL_MAIN_HANDLED
#include <SDL.h>

#include "gamepad/pads.h"
#endif

namespace gamepad_test {

using ::testing::HasSubstr;

// The rest of a stick is a tenth of its way: of 0.55, half is left.
TEST(Gamepad, SticksRestSteerLessWhenFastAndTriggersPressInProportion) {
  const auto asked = [](double stick, double throttle, double brake, double speed_mps = 0.0) {
    return gamepad::command_of({stick, throttle, brake, 0, false, false}, 3, speed_mps);
  };
  EXPECT_EQ(asked(0.1, 0.1, 0.1).steering_rad, 0.0);
  EXPECT_EQ(asked(-0.1, 0.1, 0.1).throttle, 0.0);
  EXPECT_EQ(asked(0.0, 0.1, 0.1).front_brake_pa, 0.0);
  EXPECT_DOUBLE_EQ(asked(-1.0, 0.0, 0.0).steering_rad, 0.3) << "left is positive";
  EXPECT_DOUBLE_EQ(asked(-1.1, 0.0, 0.0).steering_rad, 0.3);
  EXPECT_NEAR(asked(0.55, 0.0, 0.0).steering_rad, -0.15, 1e-12);
  EXPECT_NEAR(asked(0.55, 0.0, 0.0, 18.0).steering_rad, -0.075, 1e-12);
  EXPECT_NEAR(asked(0.0, 0.55, 0.0).throttle, 0.5, 1e-12);
  EXPECT_DOUBLE_EQ(asked(0.0, 1.0, 0.0).throttle, 1.0);
  EXPECT_DOUBLE_EQ(asked(0.0, 0.0, 1.0).front_brake_pa, 4e6);
  EXPECT_DOUBLE_EQ(asked(0.0, 0.0, 1.0).rear_brake_pa, 2.4e6);
  EXPECT_EQ(asked(0.0, 0.0, 0.0).gear, 3);
}

void wait_for(const std::string& path) {
  for (int tries = 0; tries < 1000 && !std::filesystem::exists(path); ++tries)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

TEST(Gamepad, WithoutAPadNothingIsSaidAndTheEndOfTheRunIsSeen) {
  const support::TemporaryFolder folder;
  const std::string unit = sim_tests::write_unit(
      folder,
      sim_tests::description_2("through", sim_tests::scalar_2("a", 10, "input") +
                                              sim_tests::scalar_2("b", 20, "output")),
      2);
  sim::ServeOptions options;
  options.socket_path = folder.path("s");
  options.commands = {"a"};
  options.measurements = {"b"};
  options.stop_s = 1.0;
  sim::ServeRun run;
  std::thread serves([&] { run = sim::serve_unit(unit, options); });
  wait_for(options.socket_path);
  std::ostringstream lines;
  gamepad::drive(
      options.socket_path, {}, [] { return std::nullopt; }, lines, false);
  serves.join();
  EXPECT_EQ(lines.str(), "there is no pad; plug one in\nthe run has ended\n");
  EXPECT_EQ(run.counts.commands, 0u);
}

TEST(Gamepad, WhereNobodyServesItSaysSo) {
  const support::TemporaryFolder folder;
  std::ostringstream lines;
  for (const std::string& path : {folder.path("none"), folder.path(std::string(200, 'a'))}) {
    std::string why;
    try {
      gamepad::drive(
          path, {}, [] { return std::nullopt; }, lines, false);
    } catch (const std::exception& error) {
      why = error.what();
    }
    EXPECT_THAT(why, HasSubstr(path));
  }
}

#ifdef EXAMPLE_GAMEPAD
/// A pad that a program moves. SDL has to be there.
class VirtualPad {
 public:
  VirtualPad()
      : place_(SDL_JoystickAttachVirtual(SDL_JOYSTICK_TYPE_GAMECONTROLLER, SDL_CONTROLLER_AXIS_MAX,
                                         SDL_CONTROLLER_BUTTON_MAX, 0)),
        pad_(SDL_JoystickOpen(place_)) {
    EXPECT_NE(pad_, nullptr) << SDL_GetError();
    pull(SDL_CONTROLLER_AXIS_TRIGGERLEFT, 0.0);
    pull(SDL_CONTROLLER_AXIS_TRIGGERRIGHT, 0.0);
  }
  VirtualPad(const VirtualPad&) = delete;
  VirtualPad& operator=(const VirtualPad&) = delete;
  ~VirtualPad() {
    SDL_JoystickClose(pad_);
    EXPECT_EQ(SDL_JoystickDetachVirtual(place_), 0) << SDL_GetError();
  }
  void stick(double way) {
    SDL_JoystickSetVirtualAxis(pad_, SDL_CONTROLLER_AXIS_LEFTX, static_cast<Sint16>(32767 * way));
  }
  /// A trigger at rest is at the lower end of its axis.
  void pull(SDL_GameControllerAxis trigger, double way) {
    SDL_JoystickSetVirtualAxis(pad_, trigger, static_cast<Sint16>(-32768 + 65535 * way));
  }
  void press(SDL_GameControllerButton button, bool is_down) {
    SDL_JoystickSetVirtualButton(pad_, button, is_down ? 1 : 0);
  }

 private:
  int place_;
  SDL_Joystick* pad_;
};

TEST(Gamepad, APersonDrivesAndWithoutThePadTheSafeInputActs) {
  const support::TemporaryFolder folder;
  sim::ServeOptions options;
  options.socket_path = folder.path("s");
  options.commands = {"input.steering", "input.throttle", "input.brake.fl", "input.brake.fr",
                      "input.brake.rl", "input.brake.rr", "input.gear"};
  options.measurements = {"car.vx"};
  options.starts = {{"start.speed", "20"}, {"input.gear", "2"}};
  options.safe = {{"input.throttle", 0.0}, {"input.brake.fl", 2e6}, {"input.brake.fr", 2e6}};
  options.stop_s = 60.0;
  sim::ServeRun run;
  std::thread serves([&] {
    run = sim::serve_unit(places::source() + "/vehicles/open_wheel/vehicle.yaml", options);
  });
  wait_for(options.socket_path);
  {
    gamepad::Pads pads;
    std::optional<VirtualPad> pad(std::in_place);
    int tick = 0;
    const auto person = [&]() -> std::optional<gamepad::Said> {
      switch (tick++) {
        case 0:
          pad->pull(SDL_CONTROLLER_AXIS_TRIGGERRIGHT, 1.0);
          break;
        case 30:
          pad->press(SDL_CONTROLLER_BUTTON_RIGHTSHOULDER, true);
          break;
        case 32:
          pad->press(SDL_CONTROLLER_BUTTON_RIGHTSHOULDER, false);
          pad->stick(-0.55);
          break;
        case 60:
          pad.reset();
          break;
        case 120:
          pad.emplace();
          pad->pull(SDL_CONTROLLER_AXIS_TRIGGERLEFT, 0.55);
          break;
        case 150:
          pad->press(SDL_CONTROLLER_BUTTON_START, true);
          break;
        case 180:
          pad->press(SDL_CONTROLLER_BUTTON_BACK, true);
          break;
      }
      if (tick > 1000) return gamepad::Said{0, 0, 0, 0, false, true};  // a bug
      return pads.look();
    };
    std::ostringstream lines;
    gamepad::drive(options.socket_path, {2, 6}, person, lines, false);
    EXPECT_EQ(lines.str(),
              "the pad drives\nthe pad is gone: nothing is said, so that the safe input of crgsim "
              "acts; plug one in to drive on\nthe pad drives\nended\n");
  }
  serves.join();
  EXPECT_TRUE(run.counts.asked_to_end);
  EXPECT_EQ(run.counts.broken, 0u) << run.first_broken;
  EXPECT_EQ(run.counts.resets, 1u);

  const auto column = [&](const char* name) {
    const auto at = std::find(run.columns.begin(), run.columns.end(), name);
    EXPECT_NE(at, run.columns.end()) << name;
    std::vector<double> out;
    for (std::size_t row = 0; row < run.rows(); ++row)
      out.push_back(run.values[row * run.columns.size() +
                               static_cast<std::size_t>(at - run.columns.begin())]);
    return out;
  };
  const auto throttle = column("input.throttle"), brake = column("input.brake.fl"),
             rear = column("input.brake.rr"), steering = column("input.steering"),
             gear = column("input.gear"), safe = column("safe"), resets = column("resets"),
             speed_mps = column("car.vx");
  // In real time: how many rows a phase has is the machine's.
  std::size_t at = 0;
  const auto go_to = [&](const char* what, const auto& is_it) {
    while (at < safe.size() && !is_it(at)) ++at;
    EXPECT_LT(at, safe.size()) << what;
    return std::min(at, safe.size() - 1);
  };
  const std::size_t faster = go_to("full throttle in second", [&](std::size_t i) {
    return throttle[i] == 1.0 && gear[i] == 2.0 && safe[i] == 0.0;
  });
  const std::size_t third = go_to(
      "third, and to the left", [&](std::size_t i) { return gear[i] == 3.0 && steering[i] > 0.0; });
  EXPECT_GT(speed_mps[third], speed_mps[faster]);
  // Half of the stick's way beyond its rest, at the speed of one of the rows before.
  EXPECT_NEAR(steering[third], 0.15 / (1.0 + std::pow(speed_mps[third] / 18.0, 2)), 0.005);
  const std::size_t lost = go_to("without a pad", [&](std::size_t i) { return safe[i] == 1.0; });
  EXPECT_EQ(throttle[lost], 0.0);
  EXPECT_EQ(brake[lost], 2e6);
  const std::size_t back = go_to("with a pad again", [&](std::size_t i) { return safe[i] == 0.0; });
  EXPECT_LT(speed_mps[back], speed_mps[lost] - 2.0);
  EXPECT_GT(back, lost + 50) << "1.2 s without a pad, of which 0.2 s pass before";
  go_to("braking", [&](std::size_t i) { return std::abs(brake[i] - 2e6) < 200.0; });
  EXPECT_NEAR(rear[std::min(at, rear.size() - 1)], 1.2e6, 200.0);
  const std::size_t anew = go_to("a reset", [&](std::size_t i) { return resets[i] == 1.0; });
  EXPECT_NEAR(speed_mps[anew], 20.0, 0.5);
  EXPECT_EQ(gear[anew], 2.0);
}

TEST(Gamepad, TheProgramRefusesInOneLine) {
  const support::TemporaryFolder folder;
  for (const std::vector<std::string>& words : {std::vector<std::string>{},
                                                {"s", "x"},
                                                {"s", "7"},
                                                {"s", "9", "8"},
                                                {"s", "1", "2", "3"}}) {
    const auto run = support::run_tool(EXAMPLE_GAMEPAD, words);
    EXPECT_EQ(run.code, 2);
    EXPECT_THAT(run.err, HasSubstr("SOCKET [GEAR [GEARS]]"));
  }
  const auto run = support::run_tool(EXAMPLE_GAMEPAD, {folder.path("none")});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("crgsim serve"));
}
#else
TEST(Gamepad, SdlIsInstalled) {
  GTEST_SKIP() << "built without SDL2; scripts/setup test installs libsdl2-dev";
}
#endif

}  // namespace gamepad_test
