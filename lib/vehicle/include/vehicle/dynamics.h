// The equations of motion: the time derivative of the state as a pure function.
//
// Body frame: x forward, y left, z up, origin in the design centre of mass. The body carries four
// point masses that slide along a direction fixed in the body (prismatic joints) and four rotors.
// Their accelerations are eliminated exactly (R. Featherstone, Rigid Body Dynamics Algorithms,
// 2008, chapter 7: articulated-body inertia), which leaves one symmetric 6 x 6 system.
//
// The pieces lie in dynamics/, the laws that they call in laws/.
#pragma once

#include <memory>

#include "vehicle/dynamics/body.h"
#include "vehicle/dynamics/brakes.h"
#include "vehicle/dynamics/chassis.h"
#include "vehicle/dynamics/drive.h"
#include "vehicle/dynamics/tyre.h"
#include "vehicle/dynamics/wheel.h"

namespace vehicle {

/// The time derivative of `s` under `in`. Pure: the same arguments give the same answer; cursors
/// are scratch. `Built` leaves terms out of the compiled equations; the result is bit for bit that
/// of amplitude 0. Units as in State, per second. Numbers that are not finite in the state or the
/// road travel to the result: step() names them. A pack of cars has as many roads and cursors.
template <class T, TermSet Built = kAllTerms, class Roads = Road, class Cursors = RoadCursors>
void derivative(const Car<T>& car, const State<T>& s, const Inputs<T>& in, const Roads& road,
                Cursors& cursors, State<T>& out, Detail<T>& detail) {
  std::construct_at(&detail);  // a temporary would be copied
  detail.inputs = in;
  dynamics::Evaluation<T, Built> e{car, s, in, out, detail};
  detail.to_map = e.R;
  move_body(e);
  for (std::size_t axle = 0; axle < 2; ++axle) {
    const std::array<std::size_t, 2> wheels{2 * axle, 2 * axle + 1};
    std::array<dynamics::Touch<T>, 2> touch;
    std::array<TyreFactors<T>, 2> factors;
    for (const std::size_t i : wheels) {
      const dynamics::WheelPose<T> pose = place_wheel(e, i);
      touch[i % 2] = touch_road(e, i, pose, road, cursors);
      factors[i % 2] = tyre_factors(e, i);
    }
    if (e.active(Term::tyre_relaxation)) stiffen_tyres(e, axle, factors);
    for (const std::size_t i : wheels) slip_tyre(e, i, factors[i % 2]);
    const std::array<TyreForces<T>, 2> forces = pull_tyres(e, axle, factors);
    for (const std::size_t i : wheels) {
      add_tyre(e, i, forces[i % 2], touch[i % 2]);
      heat_tread(e, i);
    }
  }
  press_springs(e);
  blow_air(e);
  push_body(e);
  run_engine(e);
  turn_driveline(e);
  brake_wheels(e);
  burn_fuel(e);
  turn_rotors(e);
  accelerate(e);
  warm_tyres(e);
}

// Compiled once, in step.cpp: half a minute in every source that calls it.
extern template void derivative(const Car<double>&, const State<double>&, const Inputs<double>&,
                                const Road&, RoadCursors&, State<double>&, Detail<double>&);

}  // namespace vehicle
