// A person drives a unit of `crgsim serve`: what a pad says becomes commands. Knows no pad itself.
#pragma once

#include <functional>
#include <iosfwd>
#include <optional>
#include <string>

namespace gamepad {

/// What a pad says. Buttons: what was pressed since it was asked before.
struct Said {
  double stick = 0.0;                  ///< -1 left to 1 right
  double throttle = 0.0, brake = 0.0;  ///< triggers, 0 to 1
  int shifts = 0;                      ///< up less down
  bool again = false, ends = false;
};

struct Command {
  double steering_rad = 0.0;  ///< left positive
  double throttle = 0.0, front_brake_pa = 0.0, rear_brake_pa = 0.0;
  int gear = 1;
};

/// Of the way of a stick or trigger: what is less is its rest, and what is more counts from there.
constexpr double kRest = 0.1;

/// What is asked of the car at this speed: the faster it is, the less a stick steers.
Command command_of(const Said& said, int gear, double speed_mps);

/// The gear in which the car begins, and how many it has.
struct Gears {
  int first = 1, count = 6;
};

/// Gives what the pad says now; nothing: there is no pad.
using Look = std::function<std::optional<Said>()>;

/// Says commands 50 times a second, until the button that ends or the end of the run. Without a pad
/// it says none: then the safe input of crgsim acts. `lines` gets a line for whatever happens and,
/// where `is_shown`, one in place that shows the drive. Throws std::runtime_error where nobody
/// serves at the Unix socket `path`.
void drive(const std::string& path, const Gears& gears, const Look& look, std::ostream& lines,
           bool is_shown);

}  // namespace gamepad
