// What changes while the car drives: the continuous state and what is commanded from outside.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "vehicle/lanes.h"

namespace vehicle {

/// Wheels in the order front left, front right, rear left, rear right everywhere.
inline constexpr std::size_t kWheels = 4;
constexpr std::size_t axle_of(std::size_t wheel) { return wheel / 2; }
constexpr bool is_left(std::size_t wheel) { return wheel % 2 == 0; }

/// Places in the state, by states.def. A group of four begins with the front left wheel.
enum StateIndex : std::size_t {
#define VEHICLE_STATE(index, name, moves, kept, recorded, small, meaning) index,
#define VEHICLE_WHEEL_STATES(index, before, after, logged, moves, kept, recorded, small, meaning) \
  index, index##_last_ = (index) + kWheels - 1,
#include "vehicle/states.def"
#undef VEHICLE_WHEEL_STATES
#undef VEHICLE_STATE
  kStateSize
};

/// How a semi-implicit step moves a state: by its rate alone, or as step.h says.
enum class Moves { kByRate, kOtherwise };

/// Whether a recording sets a state: never, alone, or only with the whole place of the body over
/// its wheels (or springs would be pressed for nothing).
enum class Recorded { kNever, kAlone, kWithBody };

struct StateInfo {
  std::string_view name;     ///< "x_m", "roll_rad", ... "travel_fl_m", ...: unit included
  std::string_view channel;  ///< of a recording
  Moves moves;
  bool kept;  ///< from one window of a replay to the next
  Recorded recorded;
  double small;  ///< size of a difference for linearising
  std::string_view meaning;
};

/// In the order of the places.
inline constexpr std::array<StateInfo, kStateSize> kStates{{
#define VEHICLE_STATE(index, name, moves, kept, recorded, small, meaning) \
  {name, name, Moves::moves, kept, Recorded::recorded, small, meaning},
#define VEHICLE_WHEEL_STATE(before, wheel, after, logged, moves, kept, recorded, small, meaning) \
  {before wheel after, logged wheel after, Moves::moves, kept, Recorded::recorded, small, meaning},
#define VEHICLE_WHEEL_STATES(index, before, after, logged, moves, kept, recorded, small, meaning) \
  VEHICLE_WHEEL_STATE(before, "fl", after, logged, moves, kept, recorded, small, meaning)         \
  VEHICLE_WHEEL_STATE(before, "fr", after, logged, moves, kept, recorded, small, meaning)         \
  VEHICLE_WHEEL_STATE(before, "rl", after, logged, moves, kept, recorded, small, meaning)         \
  VEHICLE_WHEEL_STATE(before, "rr", after, logged, moves, kept, recorded, small, meaning)
#include "vehicle/states.def"
#undef VEHICLE_WHEEL_STATES
#undef VEHICLE_WHEEL_STATE
#undef VEHICLE_STATE
}};

constexpr std::string_view state_name(std::size_t index) { return kStates[index].name; }

/// The continuous state; trivially copyable when T is.
template <class T>
struct State {
  std::array<T, kStateSize> value;

  const T& operator[](std::size_t i) const { return value[i]; }
  T& operator[](std::size_t i) { return value[i]; }
};

/// What the actuators deliver to the car. T is double or an automatic differentiation type.
template <class T>
struct Inputs {
  T steer_rad = T(0);                 ///< mean angle of the front road wheels, left positive
  T steer_rate_radps = T(0);          ///< of that angle; only turn slip asks for it
  T throttle = T(0);                  ///< 0 to 1
  std::array<T, kWheels> brake_pa{};  ///< pressure at each wheel's brake
  Int<T> gear{};                      ///< 1 to kMostGears; 0: nothing engaged; -1: reverse
  Int<T> next_gear{};                 ///< while a shift has nothing engaged: the gear to come
  T clutch = T(0);  ///< pedal: 0 released (as the clutch does by itself) to 1, no torque
  T hold_n = T(0);  ///< a push from outside, forward, at the design centre of mass
  std::array<T, kWheels> sunk_m{};     ///< deflection that does not press, see laws/ledge.h
  Flag<T> opponent = false;            ///< a car whose wake acts on this one
  T wake_x_m = T(0), wake_y_m = T(0);  ///< its place in the body frame, if so
};

}  // namespace vehicle
