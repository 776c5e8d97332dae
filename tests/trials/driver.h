// The driver of the truth car: how fast he wants to be, the line he holds, pedals and gears.
#pragma once

#include <vector>

#include "random.h"
#include "truth_car.h"

namespace trials {

/// How he drives.
struct Style {
  int laps = 1;
  unsigned long long seed = 1;
  double pace_low = 0.72, pace_high = 0.93, first_pace = 0.7;
  double sway_m = 1.5;  ///< largest offset from the line
  int sway_waves = 3;   ///< per lap
  double drive = 1.0;   ///< how hard he accelerates, against what his plan takes for possible
  double weave_rad = 0.0, weave_from_hz = 0.5,
         weave_to_hz = 2.0;  ///< steering swung to and fro, ever faster over 20 s
};

/// What he has in mind from one millisecond to the next.
struct Driver {
  Random dice;                 ///< pace and line of the laps to come
  Commands now{};              ///< what his hands and feet do, and the gear he wants
  double between_gears_s = 0;  ///< still to go without a gear
  double integral = 0, weave_rad = 0;
  int lap = -1;
  double sway_m = 0, sway_rad = 0;
  std::vector<double> speed_mps{};  ///< per node of the track, this lap
};

/// The next millisecond (`step` is its number) of a drive that has come `s_m` along the track in
/// `state`.
void act(Driver& driver, const Style& style, const TruthCar& car, const Track& track,
         const State& state, double s_m, long step);

}  // namespace trials
