// What each relation leaves over at a setting, on the way to it.
#pragma once

#include <array>
#include <vector>

#include "corrected_channels.h"
#include "gears.h"
#include "led_car.h"
#include "not_known.h"

namespace explain {

/// The road under the car at one step, with what it may be wrong by: along the body and to its
/// left.
struct Slope {
  double grade = 0.0, bank = 0.0, vertical = 0.0;
  double path_grade = 0.0;         ///< along the path, which is not where the nose points
  double leaning_more = 0.0;       ///< than the file says
  double course_rad = 0.0;         ///< of the path
  double pitching_up_radps = 0.0;  ///< of a car that lies flat on it
};

/// The motion at one step, sensors corrected.
struct Motion {
  double vx = 0.0, vy = 0.0, yaw = 0.0;  ///< yaw: the rate
  double dvx = 0.0, dvy = 0.0, dyaw = kNaN;
  double px = 0.0, py = 0.0;  ///< of the path
};

/// One recording at one setting on its way to residuals.
class Relations {
 public:
  Relations(const Signals& s, const vehicle::Vehicle& car, const Setting& set);

  void compare_commands();
  void compare_motion();
  void compare_accelerometer(const Led& led);
  void compare_force_along(const Led& led);
  void compare_forces(const Led& led);
  const Lead& by() const { return by_; }
  Residuals out() && { return std::move(out_); }

 private:
  bool has(Channel c) const { return s_.present[c]; }
  void begin_lead();
  Motion motion(std::size_t i) const;
  Slope slope(std::size_t i, const Motion& m) const;
  double lateral_mps(std::size_t i, const Motion& m, const Slope& road) const;
  void compare_kinematics(std::size_t i, const Motion& m, const Slope& road);
  void record(std::size_t i, const Motion& m, const Slope& road);

  const Signals& s_;
  const vehicle::Vehicle& car_;
  const Setting& set_;
  CorrectedChannels c_;
  Residuals out_;
  Lead by_;
  Gears gears_;
  std::array<double, 2> radius_{};    ///< in which standing wheels roll
  double front_slip_per_mps2_ = 0.0;  ///< of tyres that spin their wheels up
  std::vector<double> shifted_;       ///< steps where it is the setting's shift further along
  std::vector<bool> driven_;          ///< what drives is known
  std::vector<bool> pushed_as_led_;   ///< what drives and brakes is known, or little
  std::vector<bool> slip_known_;
  std::vector<double> recorded_x_, recorded_y_, recorded_turn_;
  std::vector<double> at_x_, at_y_, upright_, pressed_on_;  ///< of an accelerometer that stands
                                                            ///< upright on the road
};

}  // namespace explain
