// What the road's unevenness does to body and wheels of the truth car, from a drive that is known.
#pragma once

#include "drive.h"

namespace trials {

/// Springs and masses per axle: front, rear. Seven degrees of freedom, linear but for wheels that lift.
struct Ride {
  std::array<double, 2> spring{150000, 130000}, damping{6200, 5800}, bar{90000, 30000}, unsprung{18, 21};
  double tyre = 240000, tyre_damping = 250;
  double roll_inertia = 130, pitch_inertia = 850;
  bool envelops = true;  ///< a tyre of its size rolls over teeth; else it touches in one point
};

/// Fills az, roll and pitch rate, travel and load of every wheel in the rows.
void shake(Drive& drive, const Track& track, const TruthCar& car, const Ride& ride);

}  // namespace trials
