// Brakes: torque of the pads, temperatures of discs and pads.
#pragma once

#include <array>
#include <cmath>

#include "vehicle/dynamics/evaluation.h"
#include "vehicle/laws/brake_pads.h"
#include "vehicle/laws/disc_heat.h"

namespace vehicle::dynamics {

/// Torque of one brake, regularised about standstill, and the wheel's share of brake and drive.
template <class T, TermSet Built>
void press_pads(Evaluation<T, Built>& e, std::size_t i, const T& bite) {
  using P = Parameter;
  using maths::tanh;
  const std::size_t a = axle_of(i);
  WheelDetail<T>& w = e.detail.wheel[i];
  const T pressure = select(e.in.brake_pa[i] > T(0), e.in.brake_pa[i], T(0));
  T friction = e.p.axle(a, P::front_brake_friction);
  if (e.active(Term::brake_friction_temperature))
    friction = laws::pad_friction(friction, e.amplitude(Term::brake_friction_temperature),
                                  e.files.pad_friction, pressure, e.s[kDiscSurface + i]);
  friction *= bite;
  const T capacity = laws::brake_torque(friction, pressure, e.p.axle(a, P::front_brake_area_m2),
                                        e.p.axle(a, P::front_brake_radius_m));
  w.brake_nm = -capacity * tanh(T(e.spin[i] / e.p[P::brake_stop_radps]));
  w.brake_capacity_nm = capacity;
  e.spin_torque[i] += w.brake_nm + w.drive_nm;
  e.detail.power.brake += w.brake_nm * e.spin[i];
}

/// All brakes, their discs and the heat of the pads.
template <class T, TermSet Built>
void brake_wheels(Evaluation<T, Built>& e) {
  using P = Parameter;
  const T speed = norm(e.V);
  const laws::DiscAmounts<T> amount{
      e.amount(Term::brake_heating),    e.amount(Term::brake_conduction),
      e.amount(Term::brake_convection), e.amount(Term::brake_vanes),
      e.amount(Term::brake_radiation),  e.amount(Term::brake_heat_capacity)};
  const bool fades = e.active(Term::brake_fade);
  const T& heat = e.s[kPadHeat];
  const T bite =
      fades ? laws::pad_bite(e.amplitude(Term::brake_fade), e.p[P::brake_fade_1pmj], heat) : T(1);
  for (std::size_t a = 0; a < 2; ++a) {
    const laws::DiscParameters<T> disc = laws::disc_parameters(e.p, a);
    const laws::DiscAir<T> air = laws::disc_air(disc, amount, speed);
    for (std::size_t i = 2 * a; i < 2 * a + 2; ++i) {
      press_pads(e, i, bite);
      const laws::DiscRates<T> rate =
          laws::disc_heat(disc, amount, e.s[kDiscSurface + i], e.s[kDiscCore + i],
                          e.detail.wheel[i].brake_nm, e.spin[i], air);
      e.out[kDiscSurface + i] = rate.surface_kps;
      e.out[kDiscCore + i] = rate.core_kps;
    }
  }
  e.out[kPadHeat] = T(0);
  if (fades)
    e.out[kPadHeat] = laws::pad_heat_rate(T(-e.detail.power.brake), heat, e.p[P::brake_fade_s]);
}

}  // namespace vehicle::dynamics
