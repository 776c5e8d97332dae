// What a mechanism does to the car that is led along a recording.
#pragma once

#include <algorithm>

#include "explain/model.h"
#include "vehicle/car.h"
#include "vehicle/dynamics.h"

namespace explain {

/// The led car before a substep.
struct Underway {
  vehicle::Parameters<double>& parameters;
  const vehicle::Car<double>& car;
  const vehicle::Detail<double>& last;  ///< of the substep before
  double vx_mps = 0.0;
  double grip = 1.0;  ///< factor on that of all tyres
  double lift = 1.0;  ///< factor on both lift areas
};

/// Either may be null. A mechanism that calls the law of lib/vehicle switches its term on at the
/// begin; what the vehicle has no term for acts at every substep.
struct Effect {
  void (*at_begin)(vehicle::Car<double>&, const Acting&) = nullptr;
  void (*on_the_way)(Underway&, const Acting&) = nullptr;
};

/// The effect of more of a term that the stated car has not, or has in part.
template <vehicle::Term kTerm>
inline constexpr Effect kMoreOf{
    [](vehicle::Car<double>& car, const Acting& a) { car.terms[kTerm] += a.amount[0]; }};

/// The same of a term that cannot be less than nothing.
template <vehicle::Term kTerm>
inline constexpr Effect kMoreOfPositive{[](vehicle::Car<double>& car, const Acting& a) {
  car.terms[kTerm] = std::max(0.0, car.terms[kTerm] + a.amount[0]);
}};

}  // namespace explain
