// The car of lib/vehicle, led along a recording: which forces it has where it moves as recorded.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "explain/model.h"

namespace explain {

/// What leads the car, every Signals::kStep_s, sensors corrected. NaN: nothing to lead it there.
struct Lead {
  std::vector<double> vx_mps, vy_mps, yaw_radps, yaw_rad;  ///< in the plane of the road
  bool vy_known = false;      ///< false: the car finds its own side slip
  std::vector<double> steer;  ///< what the steering is asked, or the road wheels have, rad
  std::vector<double> throttle, brake_front_pa, brake_rear_pa;  ///< empty: none
  std::vector<double> brake_front_apart_pa,
      brake_rear_apart_pa;           ///< left minus right; empty: no difference
  std::vector<int> gear;             ///< 1 to vehicle::kMostGears
  std::vector<double> gravity_mps2;  ///< with what crests, dips and banked turns add
  std::vector<double> fuel_kg;       ///< on board
  double reserve_kg = 0.0;           ///< of the stated mass that can burn: so much more is on board
};

/// What the car then does, at the same times; NaN where it was not led for half a step to both
/// sides. Means over a step of time, hidden states (springs, slips, actuators, heats, boost) as
/// they came about.
struct Led {
  std::vector<double> force_x_mps2,
      force_y_mps2;  ///< of tyres and air per mass, in the road's plane
  std::vector<double> yaw_radps2;
  std::vector<double> load_front_n, load_rear_n;   ///< of both wheels
  std::vector<double> rear_radps, rear_rolling_m;  ///< means of both rear wheels
  std::vector<double> rear_difference_radps;       ///< left minus right
  std::vector<double> roll_rad, pitch_rad;         ///< of the body against the road
};

/// A drive that is known: what led it and what came of it.
struct KnownDrive {
  Setting setting;
  Lead by;
  Led led;
};

/// Whether lead() would give the same again.
bool same_drive(const KnownDrive& known, const Setting& setting, const Lead& by);

/// A car and what leads it.
struct Guided {
  const Setting* setting;
  const Lead* by;
};

/// Which of these cars can be led together, by their places: eight at most, in order.
std::vector<std::vector<std::size_t>> convoys(const Signals& signals, const vehicle::Vehicle& car,
                                              std::span<const Setting* const> settings);

/// Drives the car with the setting's amounts on a plane. Throws vehicle::Error where lib/vehicle
/// refuses the car.
Led lead(const Signals& signals, const vehicle::Vehicle& car, const Setting& setting,
         const Lead& by);
/// The same of a convoy, each bit for bit as alone. `tick`, if given, is called from time to time.
std::vector<Led> lead(const Signals& signals, const vehicle::Vehicle& car,
                      std::span<const Guided> convoy, const std::function<void()>& tick = {});

/// Whether residuals at this setting take a drive that is not known.
bool needs_drive(const Signals& signals, const vehicle::Vehicle& car, const Setting& setting,
                 const KnownDrive& known);

/// residuals() at each of these settings, with cars led together where they can be. `tick` as in
/// lead().
std::vector<Residuals> residuals(const Signals& signals, const vehicle::Vehicle& car,
                                 std::span<const Setting* const> settings, const KnownDrive& known,
                                 const std::function<void()>& tick = {});

}  // namespace explain
