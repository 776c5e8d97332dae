// One evaluation of the equations of motion under way: what the pieces share and add to.
#pragma once

#include <array>

#include "vehicle/car.h"
#include "vehicle/detail.h"

namespace vehicle::dynamics {

/// The pieces of derivative() read car, state and inputs, write rates and details, and add to the
/// accumulators. `Built` leaves terms out of the compiled equations.
template <class T, TermSet Built>
struct Evaluation {
  const Car<T>& car;
  const State<T>& s;
  const Inputs<T>& in;
  State<T>& out;
  Detail<T>& detail;
  const Parameters<T>& p = car.parameters;
  const CarFiles& files = *car.files;

  // Of the body; map or body frame.
  const Attitude<T> leaning = attitude(s[kRoll], s[kPitch], s[kYaw]);
  const Rotation<T> R = rotation(leaning);  ///< R_map_body
  const Vec3<T> V{s[kVx], s[kVy], s[kVz]};
  const Vec3<T> omega{s[kRollRate], s[kPitchRate], s[kYawRate]};
  const Vec3<T> position{s[kX], s[kY], s[kZ]};
  const Vec3<T> gravity = R.undo({T(0), T(0), -p[Parameter::environment_gravity_mps2]});

  // Accumulators: what every term adds to.
  Vec3<T> force{}, moment{};              ///< on the whole system, about the origin
  std::array<T, kWheels> travel_force{};  ///< along each wheel's travel
  std::array<T, kWheels> spin_torque{};   ///< on each wheel about its axis
  T engine_torque = T(0);

  // Of the wheels: centre, d centre / d travel, rotation / d travel, d slide / d travel.
  std::array<Vec3<T>, kWheels> centre{}, slide{}, turn{}, bend{};
  std::array<Vec3<T>, kWheels> axis{};
  std::array<T, kWheels> slide2{}, spin{};  ///< square of the slide; spin against the body

  // Filled on the way.
  std::array<Stiffness<T>, kWheels> upright{};       ///< of the tyres, by the term tyre_relaxation
  std::array<Stiffness<Pack<2>>, 2> upright_pair{};  ///< the same by axle, where T is double
  T map_torque = T(0);  ///< of the engine map or the air path, N m: what the fuel is for

  /// Whether a term is built and acts at all.
  bool active(Term t) const {
    return (Built >> static_cast<std::size_t>(t) & 1) != 0 && !is_exactly_zero(car.terms[t]);
  }
  /// Amplitude of a term that is active.
  const T& amplitude(Term t) const { return car.terms[t]; }
  /// Amplitude of any term; 0 where it is not built.
  T amount(Term t) const { return active(t) ? car.terms[t] : T(0); }
};

}  // namespace vehicle::dynamics
