// What a car of a kind has where its data sheet is silent.
#pragma once

#include <array>
#include <cstddef>

#include "vehicle/data_sheet.h"

namespace vehicle {

/// What is guessed by the kind of car.
enum class Guess : std::size_t {
  kCogHeight_m,
  kGrip,
  kDragArea_m2,
  kFrontDownforce_m2,
  kRearDownforce_m2,
  kFrontRide_hz,
  kRearRide_hz,
  kGears,
  kTyreStiffness,   ///< over that of the reference tyre, per newton
  kRoll_radpg,      ///< roll of the body per g of lateral acceleration
  kFrontHold,       ///< share of the hold against rolling in front, above that of the weight
  kYawIndex,        ///< yaw inertia over mass and the distances of the axles from the mass
  kRollGyration,    ///< radius of gyration over the mean track
  kBumpDamping,     ///< share of the critical
  kReboundDamping,  ///< share of the critical
  kFastDamping,     ///< far beyond the knee over that of slow travel
  kTravel_m,        ///< of a wheel until the stop touches
  kRollCentre_m,    ///< height of the rear one; the front has half
  kCamber_rad,      ///< of the front; the rear has two thirds
  kEfficiency,      ///< of the driveline
  kShift_s,         ///< without torque
  kEngineInertia,   ///< kg m2 over N m of its greatest torque
  kUnsprung,        ///< mass of a wheel over that of the car
  kCount
};

struct Guessed {
  std::array<double, 4> value;  ///< by CarKind
  double prior;                 ///< two standard deviations, as a share of the value
  const char* why;
};

/// A value of the kind of car, how far off it may be, and why.
const Guessed& guess(Guess what);

inline double guessed_value(Guess what, CarKind kind) {
  return guess(what).value[static_cast<std::size_t>(kind)];
}

}  // namespace vehicle
