// What effects do to the truth cars alike, and the road below a car with what they add to it.
#pragma once

#include "truth_car.h"

namespace trials {

/// Sum of the amounts of a mechanism.
double amount(const TruthCar& car, const char* mechanism);

/// The factor on a term of this car: 1 where no trial is about it.
double factor(const TruthCar& car, const char* mechanism);

/// What road effects of a mechanism add at a place.
double road_extra(const TruthCar& car, const char* mechanism, double s, double length);

/// What banking that changes along the road adds beside its middle: z = height(s) + v bank(s).
struct Warp {
  double grade = 0, vertical = 0;
};
Warp warp(const TruthCar& car, const Track& track, double s, double v);

/// The road in the directions of a car that is turned against it.
struct RoadBelow {
  double grade, bank;  ///< uphill ahead and to the left
  double plus;         ///< what presses: gravity and the road's own curvature, per mass
  double grip;
};
RoadBelow road_below(const TruthCar& car, const Track& track, const State& x, double s, double vx,
                     const Warp& warped);

/// Speed against the air, ahead and to the left.
struct Air {
  double x, y;
};
Air air_past(const TruthCar& car, const State& x, double vx, double vy);

}  // namespace trials
