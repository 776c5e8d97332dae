// What changes while the car drives: the continuous state and what is commanded from outside.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace vehicle {

/// Wheels in the order front left, front right, rear left, rear right everywhere.
inline constexpr std::size_t kWheels = 4;
constexpr std::size_t axle_of(std::size_t wheel) { return wheel / 2; }
constexpr bool is_left(std::size_t wheel) { return wheel % 2 == 0; }

/// Places in the state. A group of four begins with the front left wheel.
enum StateIndex : std::size_t {
  kX,
  kY,
  kZ,  ///< m, design centre of mass (without fuel) in the map frame
  kRoll,
  kPitch,
  kYaw,  ///< rad; yaw, then pitch (nose down positive), then roll (left up)
  kVx,
  kVy,
  kVz,  ///< m/s, velocity of that point in the body frame
  kRollRate,
  kPitchRate,
  kYawRate,                            ///< rad/s, body frame
  kTravel,                             ///< m, wheel up against the body positive, 0 = design
  kTravelRate = kTravel + kWheels,     ///< m/s
  kSpin = kTravelRate + kWheels,       ///< rad/s about the wheel's axis, forward rolling positive
  kSlipX = kSpin + kWheels,            ///< m, longitudinal deflection of the contact patch
  kSlipY = kSlipX + kWheels,           ///< m, lateral deflection, left positive
  kTyre = kSlipY + kWheels,            ///< K, tread
  kDiscSurface = kTyre + kWheels,      ///< K
  kDiscCore = kDiscSurface + kWheels,  ///< K
  kEngine = kDiscCore + kWheels,       ///< rad/s
  kBoost,                              ///< 0 to 1
  kFuel,                               ///< kg
  kPadHeat,                            ///< J that the pads of all wheels hold, see brake.fade_1pmj
  kTyreWarmth,                         ///< 0 cold to 1, of all tyres: see tyre.warm_up_loss
  // Air path of the full turbocharged engine; 0 with the first-order boost.
  kManifold,  ///< Pa, between throttle and cylinders
  kCharge,    ///< Pa, between compressor and throttle
  kExhaust,   ///< Pa, between cylinders and turbine
  kTurbo,     ///< rad/s, turbocharger's shaft
  kStateSize
};

/// The continuous state; trivially copyable when T is.
template <class T>
struct State {
  std::array<T, kStateSize> value;

  const T& operator[](std::size_t i) const { return value[i]; }
  T& operator[](std::size_t i) { return value[i]; }
};

/// "x_m", "roll_rad", ... "travel_fl_m", ...: unit included.
std::string_view state_name(std::size_t index);

/// What the actuators deliver to the car. T is double or an automatic differentiation type.
template <class T>
struct Inputs {
  T steer_rad = T(0);                  ///< mean angle of the front road wheels, left positive
  T steer_rate_radps = T(0);           ///< of that angle; only turn slip asks for it
  T throttle = T(0);                   ///< 0 to 1
  std::array<T, kWheels> brake_pa{};   ///< pressure at each wheel's brake
  int gear = 0;                        ///< 1 to 6; 0: nothing engaged; -1: reverse
  int next_gear = 0;                   ///< while a shift has nothing engaged: the gear to come
  T hold_n = T(0);  ///< a push from outside, forward, at the design centre of mass
  bool opponent = false;               ///< a car whose wake acts on this one
  T wake_x_m = T(0), wake_y_m = T(0);  ///< its place in the body frame, if so
};

}  // namespace vehicle
