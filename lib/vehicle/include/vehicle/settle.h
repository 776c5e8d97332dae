// What no explicit step resolves: frictions that can stick, and pressures that even out at once.
#pragma once

#include <array>
#include <cmath>

#include "vehicle/dynamics.h"

namespace vehicle {

namespace settling {

/// x held to -most to most.
template <class T>
T hold(const T& x, const T& most) {
  return select(x > most, most, select(x < -most, T(-most), x));
}

/// Front wheels have nothing but their brakes; rate of their spin, torque of the brake.
template <class T>
void stop_front(const Car<T>& car, double h, const State<T>& rate, const Detail<T>& detail,
                std::array<T, kWheels>& spin_rate, std::array<T, kWheels>& brake_nm) {
  for (std::size_t i = 0; i < 2; ++i) {
    const WheelDetail<T>& w = detail.wheel[i];
    const T& inertia = car.parameters[Parameter::front_wheel_inertia_kgm2];
    const T others_nm = inertia * rate[kSpin + i] - w.brake_nm;
    brake_nm[i] = hold(T(-inertia * w.spin_radps / h - others_nm), w.brake_capacity_nm);
    spin_rate[i] = (others_nm + brake_nm[i]) / inertia;
  }
}

/// Engine and driven wheels over a step: (1 - h J) change = h rate, with J the falls of clutch and
/// differential friction per slip speed. Rows: engine, left, right; the engine's is eliminated.
/// What is left: m0 on the diagonal, m1 beside it, `free` on the right, without the brakes, of
/// which every newton metre adds h / inertia.
template <class T>
struct Driven {
  T clutch_fall, differential_fall, differential_nm;  ///< N m s, N m s, N m
  T half;                                             ///< of the gear ratio
  T a00, a01, b0;                                     ///< of the engine's row
  std::array<T, 2> free;
  T m0, m1;

  T engine_change(const std::array<T, 2>& change) const {
    return (b0 - a01 * (change[0] + change[1])) / a00;
  }
};

/// Where friction alone would carry the slip through zero within the step, the slope that ends it
/// just there.
template <class T>
T fall(double h, const T& slope, const T& torque, const T& slip, const T& inertia) {
  using std::abs;
  const auto steeper = [&] {
    const T ending = abs(T(torque / slip)) - inertia / h;
    return select(ending > slope, ending, slope);
  };
  return choose(
      value_of(slip) == 0.0, [&] { return slope; }, steeper);
}

template <class T>
Driven<T> couple(const Car<T>& car, double h, const State<T>& rate, const Detail<T>& detail) {
  using P = Parameter;
  const Parameters<T>& p = car.parameters;
  const T& inertia_w = p[P::rear_wheel_inertia_kgm2];
  const T& inertia_e = p[P::engine_inertia_kgm2];
  const T& e = detail.drive_efficiency;
  Driven<T> d;
  const T half = d.half = 0.5 * detail.gear_ratio;
  const auto clutched = [&] {
    return fall(h, detail.clutch_stiffness_nms, detail.clutch_nm, detail.clutch_slip_radps,
                T(1.0 / (1.0 / inertia_e + 2.0 * half * half * e / inertia_w)));
  };
  const T c = choose(
      exactly_zero(detail.gear_ratio), [] { return T(0); }, clutched);
  d.clutch_fall = c;
  d.a00 = 1.0 + h * c / inertia_e;
  d.a01 = -h * c * half / inertia_e;
  const T a10 = -h * c * half * e / inertia_w;
  const T through = h * (c * half * half * e) / inertia_w;
  d.b0 = h * rate[kEngine];
  const T eliminated = a10 * d.a01 / d.a00;
  for (std::size_t i = 0; i < 2; ++i)
    d.free[i] =
        h * (rate[kSpin + 2 + i] - detail.wheel[2 + i].brake_nm / inertia_w) - a10 * d.b0 / d.a00;
  // The mean of both wheels does not see the differential: it gives the clutch torque of the step,
  // on which the limited slip depends.
  T slope = detail.differential_stiffness_nms;
  d.differential_nm = detail.differential_nm;
  const auto limited = !exactly_zero(detail.limited_slip_nm);
  if (any(limited)) {
    const T both = (d.free[0] + d.free[1] +
                    h / inertia_w * (detail.wheel[2].brake_nm + detail.wheel[3].brake_nm)) /
                   (1.0 + 2.0 * (through - eliminated));
    const T clutch_nm = detail.clutch_nm + c * ((d.b0 - d.a01 * both) / d.a00 - half * both);
    const T more_nm = laws::limited_slip_torque(p, car.terms[Term::limited_slip],
                                                T(clutch_nm * detail.gear_ratio * e)) -
                      detail.limited_slip_nm;
    const T& grip = detail.limited_slip_grip;
    const auto set = [&](T& to, const T& value) { to = select(limited, value, to); };
    set(d.differential_nm, T(d.differential_nm + more_nm * grip));
    set(slope, T(slope + more_nm * (1.0 - grip * grip) / p[P::differential_stick_radps]));
    set(d.free[0], T(d.free[0] - h / inertia_w * more_nm * grip));
    set(d.free[1], T(d.free[1] + h / inertia_w * more_nm * grip));
  }
  const T k = fall(h, slope, d.differential_nm, detail.differential_slip_radps, T(0.5 * inertia_w));
  d.differential_fall = k;
  const T lock = h * k / inertia_w;
  d.m0 = 1.0 + through + lock - eliminated;
  d.m1 = through - lock - eliminated;
  return d;
}

/// The changes of both driven wheels' spins, and the torques of their brakes: a brake slides with
/// all it has, or holds its wheel with what that takes. At most one of both decisions changes in a
/// round.
template <class T>
std::array<T, 2> stop_rear(const Driven<T>& d, double h, const T& inertia_w,
                           const Detail<T>& detail, std::array<T, kWheels>& brake_nm) {
  using std::abs;
  const T &m0 = d.m0, &m1 = d.m1;
  std::array<T, 2> change;
  std::array<Flag<T>, 2> holds, slides;
  for (std::size_t i = 0; i < 2; ++i) {
    const WheelDetail<T>& w = detail.wheel[2 + i];
    const Real<T> spin = value_of(w.spin_radps);
    slides[i] = !(value_of(w.brake_capacity_nm) > 0.0);
    holds[i] = !slides[i] && spin == 0.0;
    brake_nm[2 + i] = select(spin > 0.0, T(-w.brake_capacity_nm), w.brake_capacity_nm);
  }
  for (int round = 0; round < 5; ++round) {
    const auto right = [&](std::size_t i) { return d.free[i] + h / inertia_w * brake_nm[2 + i]; };
    const auto stop = [&](std::size_t i) { return T(-detail.wheel[2 + i].spin_radps); };
    // Of a wheel that turns, beside another that stops (`held`) or turns.
    const auto turning = [&](std::size_t i, const Flag<T>& held) {
      return choose(
          held, [&] { return T((right(i) - m1 * stop(1 - i)) / m0); },
          [&] { return T((m0 * right(i) - m1 * right(1 - i)) / (m0 * m0 - m1 * m1)); });
    };
    for (std::size_t i = 0; i < 2; ++i)
      change[i] = choose(
          holds[i], [&] { return stop(i); }, [&] { return turning(i, holds[1 - i]); });
    Flag<T> done = true;  // for good: another round decides nothing else
    for (std::size_t i = 0; i < 2; ++i) {
      const WheelDetail<T>& w = detail.wheel[2 + i];
      const Flag<T> held = done && holds[i];
      const Flag<T> stops =
          done && !holds[i] && !slides[i] && w.spin_radps * (w.spin_radps + change[i]) <= T(0);
      if (any(held)) {
        const T needed_nm = (m0 * change[i] + m1 * change[1 - i] - d.free[i]) * inertia_w / h;
        const Flag<T> torn = held && abs(needed_nm) > w.brake_capacity_nm;
        brake_nm[2 + i] = select(held, hold(needed_nm, w.brake_capacity_nm), brake_nm[2 + i]);
        slides[i] = slides[i] || torn;
        holds[i] = holds[i] && !torn;
        done = done && !torn;
      }
      holds[i] = holds[i] || stops;
      done = done && !stops;
    }
    if (all(done)) break;
  }
  return change;
}

/// The body takes the reaction of every torque on a wheel that differs from the state's.
template <class T>
void react_body(const Car<T>& car, const std::array<T, kWheels>& spin_rate, State<T>& rate,
                Detail<T>& detail) {
  Vec3<T> moment;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const T& inertia = car.parameters.axle(axle_of(i), Parameter::front_wheel_inertia_kgm2);
    moment -= (car.terms[Term::wheel_reaction] * inertia * (spin_rate[i] - rate[kSpin + i])) *
              detail.wheel[i].axis;
    rate[kSpin + i] = spin_rate[i];
  }
  std::array<T, 6> x{T(0), T(0), T(0), moment.x, moment.y, moment.z};
  dynamics::solve6(detail.inertia, x);
  const Vec3<T> acceleration{x[0], x[1], x[2]}, angular{x[3], x[4], x[5]};
  for (std::size_t i = 0; i < 6; ++i) rate[kVx + i] += x[i];
  detail.specific_force_mps2 = detail.specific_force_mps2 + acceleration;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const WheelDetail<T>& w = detail.wheel[i];
    const Vec3<T> a = acceleration + cross(angular, w.centre);
    rate[kTravelRate + i] -= dot(a, w.slide) / dot(w.slide, w.slide);
  }
}

}  // namespace settling

/// Gives wheels, engine and body the friction torques that act over the next step of length
/// `step_s`, in place of those of the state: no explicit step resolves a friction that can stick.
/// Brakes: the torque that ends the turning at the end of the step, or all they have (a
/// time-stepping contact law, J. J. Moreau, 1988): a wheel that its brake can hold stands still.
/// Clutch and differential: their torque at the end of the step, by the slope of the regularised
/// law; where friction alone would carry the slip through zero within the step, by the slope that
/// ends it just there. So a stick speed far too small for the step does not chatter. The torques
/// and the specific force in `detail` become those of the step; its powers and the heats in `rate`
/// stay those of the state.
template <class T>
void settle_frictions(const Car<T>& car, double step_s, State<T>& rate, Detail<T>& detail) {
  const double h = step_s;
  std::array<T, kWheels> spin_rate, brake_nm;
  settling::stop_front(car, h, rate, detail, spin_rate, brake_nm);
  const settling::Driven<T> d = settling::couple(car, h, rate, detail);
  const std::array<T, 2> change = settling::stop_rear(
      d, h, car.parameters[Parameter::rear_wheel_inertia_kgm2], detail, brake_nm);
  spin_rate[2] = change[0] / h;
  spin_rate[3] = change[1] / h;
  const T engine_change = d.engine_change(change);
  rate[kEngine] = engine_change / h;
  detail.clutch_nm += d.clutch_fall * (engine_change - d.half * (change[0] + change[1]));
  detail.differential_nm = d.differential_nm + d.differential_fall * (change[0] - change[1]);
  const T driven_nm = detail.clutch_nm * detail.gear_ratio * detail.drive_efficiency;
  detail.wheel[2].drive_nm = 0.5 * driven_nm - detail.differential_nm;
  detail.wheel[3].drive_nm = 0.5 * driven_nm + detail.differential_nm;
  for (std::size_t i = 0; i < kWheels; ++i) detail.wheel[i].brake_nm = brake_nm[i];
  settling::react_body(car, spin_rate, rate, detail);
}

/// Gives the pressures of the full turbocharged engine the rates that they have at the end of the
/// step, by their Jacobian (linearly implicit Euler): flow through an open throttle equals
/// pressures within a fraction of a millisecond, which no explicit step resolves.
template <class T>
void settle_air(double step_s, State<T>& rate, const Detail<T>& detail) {
  const double h = step_s;
  const auto& d = detail.turbo.drift;
  const T mm = 1.0 - h * d.manifold, mc = -h * d.manifold_charge;
  const T cm = -h * d.charge_manifold, cc = 1.0 - h * d.charge;
  const T determinant = mm * cc - mc * cm;
  const T manifold = rate[kManifold], charge = rate[kCharge];
  rate[kManifold] = (cc * manifold - mc * charge) / determinant;
  rate[kCharge] = (mm * charge - cm * manifold) / determinant;
  rate[kExhaust] /= 1.0 - h * d.exhaust;
}

}  // namespace vehicle
