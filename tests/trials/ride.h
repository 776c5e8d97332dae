// What the road's unevenness does to body and wheels of the truth car, from a drive that is known.
#pragma once

#include "drive.h"

namespace trials {

/// Springs and masses per axle: front, rear. Seven degrees of freedom, linear but for wheels that
/// lift.
struct Ride {
  std::array<double, 2> spring{150000, 130000}, damping{6200, 5800}, bar{90000, 30000},
      unsprung{18, 21};
  double tyre = 240000, tyre_damping = 250;
  double roll_inertia = 130, pitch_inertia = 850;
  bool envelops = true;  ///< a tyre of its size rolls over teeth; else it touches in one point
};

/// Fills az, roll and pitch rate, travel and load of every wheel in the rows.
void shake(Drive& drive, const Track& track, const TruthCar& car, const Ride& ride);

/// Discs of a ring and a hat; heat passes between them better when they are hot.
struct Discs {
  double begin_k = 295;  ///< a cold start
  std::array<double, 2> ring{900, 700}, hat{1900, 1500}, conductance{260, 220};
  double slope_1pk = 0.0;  ///< of the conductance, about 480 K
};

/// Fills the temperature of every disc's ring in the rows.
void heat(Drive& drive, const TruthCar& car, const Discs& discs);

}  // namespace trials
