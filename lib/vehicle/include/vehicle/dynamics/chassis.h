// Forces on the chassis: springs and dampers along the travel, the air, a push from outside.
#pragma once

#include <cmath>

#include "vehicle/dynamics/evaluation.h"
#include "vehicle/laws/aero.h"
#include "vehicle/laws/suspension.h"
#include "vehicle/laws/wake.h"

namespace vehicle::dynamics {

/// Springs, bars, stops and dampers.
template <class T, TermSet Built>
void press_springs(Evaluation<T, Built>& e) {
  using P = Parameter;
  const laws::SpringAmounts<T> amount{e.amount(Term::anti_roll_bar), e.amount(Term::bump_stop)};
  for (std::size_t i = 0; i < kWheels; ++i) {
    const std::size_t a = axle_of(i);
    const T& rate = e.s[kTravelRate + i];
    const T& unsprung_kg = e.p.axle(a, P::front_unsprung_mass_kg);
    const T spring = laws::spring_force(
        e.p, amount, a, is_left(i) ? 1.0 : -1.0,
        T(e.car.static_load_n[a] - unsprung_kg * e.p[P::environment_gravity_mps2]),
        e.s[kTravel + i], e.s[kTravel + (i ^ 1u)]);
    const T damper = e.files.damper_n[a].empty() ? laws::damper_force(e.p, a, rate)
                                                 : evaluate(e.files.damper_n[a], rate);
    e.detail.wheel[i].damper_n = damper;
    e.detail.power.damper -= damper * rate;
    e.travel_force[i] += spring - damper + unsprung_kg * dot(e.gravity, e.slide[i]);
  }
}

/// Drag and downforce in straight flow, times what maps of ride height, yaw and wake make of them.
template <class T, TermSet Built>
laws::AirForces<T> air_with_maps(const Evaluation<T, Built>& e, const Vec3<T>& air,
                                 const T& air_speed, const T& air_speed2) {
  using laws::map_factor;
  using maths::atan2;
  using std::abs;
  const CarFiles& files = e.files;
  laws::AirForces<T> f = laws::air_forces(e.p, air_speed, air_speed2);
  if (e.active(Term::aero_ride_height)) {
    const T& k = e.amplitude(Term::aero_ride_height);
    const auto& wheel = e.detail.wheel;
    const T front = 0.5 * (wheel[0].ride_m + wheel[1].ride_m);
    const T rear = 0.5 * (wheel[2].ride_m + wheel[3].ride_m);
    f.drag_nspm *= map_factor(k, files.drag_factor, front, rear);
    f.front_n *= map_factor(k, files.front_lift_factor, front, rear);
    f.rear_n *= map_factor(k, files.rear_lift_factor, front, rear);
  }
  if (e.active(Term::aero_yaw)) {
    const T& k = e.amplitude(Term::aero_yaw);
    const T yaw = abs(atan2(air.y, air.x));
    f.drag_nspm *= map_factor(k, files.yaw_drag_factor, yaw);
    const T lift = map_factor(k, files.yaw_lift_factor, yaw);
    f.front_n *= lift;
    f.rear_n *= lift;
  }
  if (e.active(Term::aero_slipstream) && any(e.in.opponent)) {
    const T& k = e.amplitude(Term::aero_slipstream);
    const auto factor = [&](const Map2& map) {
      return select(e.in.opponent, laws::wake_factor(k, map, e.in.wake_x_m, e.in.wake_y_m), T(1));
    };
    f.drag_nspm *= factor(files.wake_drag_factor);
    const T lift = factor(files.wake_lift_factor);
    f.front_n *= lift;
    f.rear_n *= lift;
  }
  return f;
}

/// Aerodynamics. Drag acts against the flow and downforce across it, as wind tunnels state them: a
/// body that squats does not turn its downforce into a push.
template <class T, TermSet Built>
void blow_air(Evaluation<T, Built>& e) {
  using P = Parameter;
  using maths::cos;
  using maths::sin;
  using std::sqrt;
  Vec3<T> air = e.V;
  if (e.active(Term::wind)) {
    const T w = e.amplitude(Term::wind) * e.p[P::environment_wind_mps];
    air -= e.R.undo({w * cos(e.p[P::environment_wind_heading_rad]),
                     w * sin(e.p[P::environment_wind_heading_rad]), T(0)});
  }
  const T air_speed2 = air.x * air.x + air.y * air.y;
  const auto blows = air_speed2 > T(1e-12);
  if (!any(blows)) return;
  const T air_speed = sqrt(air_speed2);
  const laws::AirForces<T> f = air_with_maps(e, air, air_speed, air_speed2);
  Detail<T>& detail = e.detail;
  const auto set = [&](auto& to, const auto& value) { to = select(blows, value, to); };
  const auto push = [&](const Vec3<T>& force, const Vec3<T>& at, T& account) {
    set(e.force, e.force + force);
    const Vec3<T> m = cross(at, force);
    set(e.moment, e.moment + m);
    set(account, T(account + (dot(force, e.V) + dot(m, e.omega))));
  };
  if (e.active(Term::aero_drag)) {
    const T& k = e.amplitude(Term::aero_drag);
    const T height = e.p[P::aero_drag_height_m] - e.p[P::chassis_cog_height_m];
    set(detail.drag_n, T(k * f.drag_nspm * air_speed));
    set(detail.drag, T(-k * f.drag_nspm) * air);
    push(detail.drag, {T(0), T(0), height}, detail.power.drag);
    set(detail.side_n, laws::side_force(e.p, k, air_speed, air.y));
    push({T(0), detail.side_n, T(0)}, {-e.p[P::aero_side_behind_cog_m], T(0), height},
         detail.power.side);
  }
  if (e.active(Term::aero_downforce)) {
    const T& k = e.amplitude(Term::aero_downforce);
    set(detail.front_downforce_n, T(k * f.front_n));
    set(detail.rear_downforce_n, T(k * f.rear_n));
    const T rise = air.z / air_speed2;
    set(detail.down, Vec3<T>{rise * air.x, rise * air.y, T(-1)});
    push(detail.front_downforce_n * detail.down, {e.car.wheel_m[0].x, T(0), T(0)},
         detail.power.downforce);
    push(detail.rear_downforce_n * detail.down, {e.car.wheel_m[2].x, T(0), T(0)},
         detail.power.downforce);
  }
}

/// The push from outside, at the origin.
template <class T, TermSet Built>
void push_body(Evaluation<T, Built>& e) {
  if (is_exactly_zero(e.in.hold_n)) return;
  const auto held = !exactly_zero(e.in.hold_n);
  e.force.x = select(held, T(e.force.x + e.in.hold_n), e.force.x);
  e.detail.power.hold = select(held, T(e.in.hold_n * e.V.x), T(0));
}

}  // namespace vehicle::dynamics
