// What a tyre does at its contact: factors, slip, forces, heat.
#pragma once

#include <array>
#include <cmath>
#include <type_traits>

#include "vehicle/dynamics/wheel.h"
#include "vehicle/laws/contact_patch.h"
#include "vehicle/laws/tyre_heat.h"
#include "vehicle/laws/tyre_warm_up.h"

namespace vehicle::dynamics {

/// Factors on the tyre file: of the car, the road, the tread's temperature and the warmth.
template <class T, TermSet Built>
TyreFactors<T> tyre_factors(const Evaluation<T, Built>& e, std::size_t i) {
  using P = Parameter;
  const std::size_t a = axle_of(i);
  TyreFactors<T> factors;
  factors.grip_x = e.p.axle(a, P::front_tyre_grip);
  factors.grip_y = e.p.axle(a, P::front_tyre_grip);
  factors.stiffness_x = e.p.axle(a, P::front_tyre_slip_stiffness);
  factors.stiffness_y = e.p.axle(a, P::front_tyre_cornering_stiffness);
  factors.combined_slip = e.amount(Term::tyre_combined_slip);
  factors.load_sensitivity = e.amount(Term::tyre_load_sensitivity);
  factors.camber = e.amount(Term::tyre_camber);
  if (e.active(Term::road_friction)) {
    const T road_grip =
        1.0 + e.amplitude(Term::road_friction) *
                  (e.p[P::environment_road_grip] * e.detail.wheel[i].road.friction - 1.0);
    factors.grip_x *= road_grip;
    factors.grip_y *= road_grip;
  }
  if (e.active(Term::tyre_thermal)) {
    const laws::TreadFactors<T> tread = laws::tread_factors(
        e.p, e.files.tyre_grip, e.amplitude(Term::tyre_thermal), e.s[kTyre + i]);
    factors.grip_x *= tread.grip;
    factors.grip_y *= tread.grip;
    factors.stiffness_x *= tread.stiffness;
    factors.stiffness_y *= tread.stiffness;
  }
  if (e.active(Term::tyre_warm_up)) {
    const T missing = laws::warm_up_missing(
        T(e.amplitude(Term::tyre_warm_up) * e.p[P::tyre_warm_up_loss]), e.s[kTyreWarmth]);
    factors.grip_x *= 1.0 - missing;
    factors.grip_y *= 1.0 - missing;
    factors.stiffness_y *= laws::warm_up_stiffness(missing);
  }
  return factors;
}

/// The patch's deflections as states: their rates, and the slips that they stand for.
template <class T, TermSet Built>
void relax_tyre(Evaluation<T, Built>& e, std::size_t i, const TyreFactors<T>& factors,
                const T& transport_x, const T& transport_y) {
  using P = Parameter;
  using std::abs;
  WheelDetail<T>& w = e.detail.wheel[i];
  const TyreCoefficients& tyre = e.files.tyre[axle_of(i)];
  const T& pressure = e.p.axle(axle_of(i), P::front_tyre_pressure_pa);
  const T &u_x = e.s[kSlipX + i], &u_y = e.s[kSlipY + i];
  T &rate_x = e.out[kSlipX + i], &rate_y = e.out[kSlipY + i];
  const Stiffness<T>& origin = e.upright[i];
  const Relaxation<T> sigma = relaxation_lengths(tyre, w.fz_n, origin.slip_n, origin.cornering_npr,
                                                 T(w.camber_rad * factors.camber), pressure);
  const bool damped = e.active(Term::tyre_carcass_damping);
  const T tau =
      damped ? T(e.amplitude(Term::tyre_carcass_damping) * e.p[P::tyre_carcass_damping_s]) : T(0);
  const laws::PatchLag<T> x = laws::patch_lag(transport_x, sigma.longitudinal_m, tau);
  const laws::PatchLag<T> y = laws::patch_lag(transport_y, sigma.lateral_m, tau);
  w.decay_x_1ps = x.decay_1ps;
  w.decay_y_1ps = y.decay_1ps;
  w.yield_x = x.yield;
  w.yield_y = y.yield;
  rate_x = -w.yield_x * w.slip_x_mps - w.decay_x_1ps * u_x;
  rate_y = w.yield_y * w.slip_y_mps - w.decay_y_1ps * u_y;
  T along = u_x, across = u_y;
  if (damped) {
    along += tau * rate_x;
    across += tau * rate_y;
  }
  const T forward = abs(w.vx_mps);
  const T pace_x = larger(forward, T(abs(w.slip_x_mps)));
  const T pace_y = larger(forward, T(abs(w.slip_y_mps)));
  const T slow(laws::kSlowSliding_mps);
  const auto creeps = w.fz_n > T(0) && (pace_x < slow || pace_y < slow);
  if (any(creeps)) {
    const Friction<T> peak = peak_friction(tyre, w.fz_n, pressure, factors);
    const T excess_x = laws::patch_unwinding(pace_x, T(abs(peak.x * w.fz_n / origin.slip_n)),
                                             sigma.longitudinal_m, u_x);
    const T excess_y = laws::patch_unwinding(pace_y, T(abs(peak.y * w.fz_n / origin.cornering_npr)),
                                             sigma.lateral_m, u_y);
    rate_x = select(creeps, T(rate_x - excess_x * u_x), rate_x);
    rate_y = select(creeps, T(rate_y - excess_y * u_y), rate_y);
    w.decay_x_1ps = select(creeps, T(w.decay_x_1ps + excess_x), w.decay_x_1ps);
    w.decay_y_1ps = select(creeps, T(w.decay_y_1ps + excess_y), w.decay_y_1ps);
  }
  const T& k = e.amplitude(Term::tyre_relaxation);
  const T kappa = along / sigma.longitudinal_m, tan_alpha = across / sigma.lateral_m;
  w.kappa += k * (kappa - w.kappa);
  w.tan_alpha += k * (tan_alpha - w.tan_alpha);
}

/// The slips that the tyre formula is given.
template <class T, TermSet Built>
void slip_tyre(Evaluation<T, Built>& e, std::size_t i, const TyreFactors<T>& factors) {
  using std::abs;
  WheelDetail<T>& w = e.detail.wheel[i];
  const T& low = e.p[Parameter::tyre_low_speed_mps];
  const T forward = abs(w.vx_mps);
  const T transport_x = laws::patch_transport(forward, w.slip_x_mps);
  const T transport_y = laws::patch_transport(forward, w.slip_y_mps);
  w.kappa = -w.slip_x_mps / larger(transport_x, low);
  w.tan_alpha = w.slip_y_mps / larger(transport_y, low);
  e.out[kSlipX + i] = T(0);
  e.out[kSlipY + i] = T(0);
  if (e.active(Term::tyre_relaxation)) relax_tyre(e, i, factors, transport_x, transport_y);
  w.kappa = laws::clip(w.kappa, -laws::kLargestSlip, laws::kLargestSlip);
  w.tan_alpha = laws::clip(w.tan_alpha, -laws::kLargestSlip, laws::kLargestSlip);
}

/// What the tyre formula is asked, as if the tyre were on the side of the car that the file's is:
/// `side` -1 where it is not.
template <class T, TermSet Built>
TyreInput<T> ask_tyre(const Evaluation<T, Built>& e, std::size_t i, double side) {
  using P = Parameter;
  using std::abs;
  const std::size_t a = axle_of(i);
  const WheelDetail<T>& w = e.detail.wheel[i];
  TyreInput<T> slip;
  slip.fz_n = w.fz_n;
  slip.kappa = w.kappa;
  slip.tan_alpha = side * w.tan_alpha;
  slip.gamma_rad = side * w.camber_rad;
  slip.vx_mps = w.vx_mps;
  slip.pressure_pa = e.p.axle(a, P::front_tyre_pressure_pa);
  if (has_turn_slip(e.files.tyre[a]) && e.active(Term::tyre_turn_slip)) {
    const T turning = dot(e.omega, w.normal) + (a == 0 ? e.in.steer_rate_radps : T(0));
    slip.turn_1pm = side * (turning / larger(T(abs(w.vx_mps)), e.p[P::tyre_turn_speed_mps]));
  }
  return slip;
}

/// The tyre formula's answer, with turn slip where the file and its term have it. U: T, or a pack
/// of both wheels of the axle.
template <class U, class T, TermSet Built>
TyreForces<U> pull_tyre(const Evaluation<T, Built>& e, std::size_t axle, TyreInput<U> slip,
                        const Stiffness<U>& upright, const TyreFactors<U>& factors) {
  const TyreCoefficients& tyre = e.files.tyre[axle];
  if (e.active(Term::tyre_relaxation)) slip.upright = &upright;
  TyreOptions options = e.car.tyre_options;
  options.moments = e.active(Term::tyre_moments) || e.active(Term::rolling_resistance);
  TyreForces<U> f = tyre_forces(tyre, slip, factors, options);
  if (!has_turn_slip(tyre) || !e.active(Term::tyre_turn_slip)) return f;
  const T& k = e.amplitude(Term::tyre_turn_slip);
  if (!is_exactly_zero(T(1.0 - k))) {
    slip.turn_1pm = U(0);
    const TyreForces<U> rolling = tyre_forces(tyre, slip, factors, options);
    f.fx_n = rolling.fx_n + k * (f.fx_n - rolling.fx_n);
    f.fy_n = rolling.fy_n + k * (f.fy_n - rolling.fy_n);
    f.mx_nm = rolling.mx_nm + k * (f.mx_nm - rolling.mx_nm);
    f.my_nm = rolling.my_nm + k * (f.my_nm - rolling.my_nm);
    f.mz_nm = rolling.mz_nm + k * (f.mz_nm - rolling.mz_nm);
  }
  return f;
}

/// Both wheels of an axle as a pack of two, whose lanes have the bits of one wheel after the other.
inline TyreFactors<Pack<2>> pair(const std::array<TyreFactors<double>, 2>& of) {
  const auto both = [&](double TyreFactors<double>::*m) {
    return vehicle::pair(of[0].*m, of[1].*m);
  };
  using F = TyreFactors<double>;
  return {both(&F::grip_x),      both(&F::grip_y),        both(&F::stiffness_x),
          both(&F::stiffness_y), both(&F::combined_slip), both(&F::load_sensitivity),
          both(&F::camber)};
}

/// Stiffnesses of an axle's upright tyres, for the term tyre_relaxation.
template <class T, TermSet Built>
void stiffen_tyres(Evaluation<T, Built>& e, std::size_t axle,
                   const std::array<TyreFactors<T>, 2>& factors) {
  const TyreCoefficients& tyre = e.files.tyre[axle];
  const T& pressure = e.p.axle(axle, Parameter::front_tyre_pressure_pa);
  const auto load = [&](std::size_t k) -> const T& { return e.detail.wheel[2 * axle + k].fz_n; };
  if constexpr (std::is_same_v<T, double>) {
    const Stiffness<Pack<2>> both = e.upright_pair[axle] =
        tyre_stiffness(tyre, vehicle::pair(load(0), load(1)), Pack<2>(pressure), pair(factors));
    for (std::size_t k = 0; k < 2; ++k)
      e.upright[2 * axle + k] = {both.slip_n[k], both.cornering_npr[k], both.within_slip_n[k],
                                 both.within_cornering_npr[k]};
  } else {
    for (std::size_t k = 0; k < 2; ++k)
      e.upright[2 * axle + k] = tyre_stiffness(tyre, load(k), pressure, factors[k]);
  }
}

/// Forces and moments of an axle's tyres, left and right.
template <class T, TermSet Built>
std::array<TyreForces<T>, 2> pull_tyres(const Evaluation<T, Built>& e, std::size_t axle,
                                        const std::array<TyreFactors<T>, 2>& factors) {
  const std::size_t left = 2 * axle;
  const double side = e.files.tyre[axle].left_side ? 1.0 : -1.0;  // of the left wheel
  const TyreInput<T> one = ask_tyre(e, left, side), other = ask_tyre(e, left + 1, -side);
  std::array<TyreForces<T>, 2> out;
  if constexpr (std::is_same_v<T, double>) {
    const auto both = [&](double TyreInput<double>::*m) { return vehicle::pair(one.*m, other.*m); };
    using I = TyreInput<double>;
    const TyreInput<Pack<2>> slip{both(&I::fz_n),      both(&I::kappa),  both(&I::tan_alpha),
                                  both(&I::gamma_rad), both(&I::vx_mps), both(&I::pressure_pa),
                                  both(&I::turn_1pm)};
    const TyreForces<Pack<2>> f = pull_tyre(e, axle, slip, e.upright_pair[axle], pair(factors));
    for (std::size_t k = 0; k < 2; ++k)
      out[k] = {f.fx_n[k],
                f.fy_n[k],
                f.mx_nm[k],
                f.my_nm[k],
                f.mz_nm[k],
                f.slip_stiffness_n[k],
                f.cornering_stiffness_npr[k],
                f.mu_x[k],
                f.mu_y[k]};
  } else {
    out = {pull_tyre(e, axle, one, e.upright[left], factors[0]),
           pull_tyre(e, axle, other, e.upright[left + 1], factors[1])};
  }
  // Back to the wheel's own side; a tyre in the air keeps its plain zeros.
  const std::size_t turned = side < 0.0 ? 0 : 1;
  const auto loaded = e.detail.wheel[left + turned].fz_n > T(0);
  for (T* x : {&out[turned].fy_n, &out[turned].mx_nm, &out[turned].mz_nm})
    *x = select(loaded, T(-*x), *x);
  return out;
}

/// Adds the tyre's forces and moments to body, travel and spin, and their powers.
template <class T, TermSet Built>
void add_tyre(Evaluation<T, Built>& e, std::size_t i, const TyreForces<T>& f,
              const Touch<T>& touch) {
  WheelDetail<T>& w = e.detail.wheel[i];
  const Vec3<T>& n = w.normal;
  w.fx_n = f.fx_n;
  w.fy_n = f.fy_n;
  Vec3<T> couple;  // on the wheel, at the contact point
  if (e.active(Term::tyre_moments)) {
    couple += (e.amplitude(Term::tyre_moments) * f.mx_nm) * w.heading;
    couple += (e.amplitude(Term::tyre_moments) * f.mz_nm) * n;
  }
  if (e.active(Term::rolling_resistance))
    couple += (e.amplitude(Term::rolling_resistance) * f.my_nm) * w.left;
  if (e.files.fx_arm == FxArm::kRollingRadius)
    couple -= (w.fx_n * (w.rolling_radius_m - touch.radius_m)) * e.axis[i];

  const Vec3<T> tangential = w.fx_n * w.heading + w.fy_n * w.left;
  const Vec3<T> contact_force = w.fz_n * n + tangential;
  e.force += contact_force;
  e.moment += cross(w.contact_m, contact_force) + couple;
  e.travel_force[i] += dot(contact_force, w.swing) + dot(couple, e.turn[i]);
  const T wheel_moment = dot(cross(w.arm, contact_force) + couple, e.axis[i]);
  e.spin_torque[i] += wheel_moment;
  w.couple = couple;
  w.couple_on_travel = dot(couple, e.turn[i]);
  const Vec3<T> tread = touch.velocity_mps + e.spin[i] * cross(e.axis[i], w.arm);
  Powers<T>& power = e.detail.power;
  power.tyre_normal += w.fz_n * dot(n, tread);
  power.tyre_x += w.fx_n * dot(w.heading, tread);
  power.tyre_y += w.fy_n * dot(w.left, tread);
  power.tyre_moment += dot(couple, e.omega) + dot(couple, e.turn[i]) * e.s[kTravelRate + i] +
                       dot(couple, e.axis[i]) * e.spin[i];
}

/// Rate of the tread's temperature.
template <class T, TermSet Built>
void heat_tread(Evaluation<T, Built>& e, std::size_t i) {
  e.out[kTyre + i] = T(0);
  if (!e.active(Term::tyre_thermal)) return;
  const WheelDetail<T>& w = e.detail.wheel[i];
  e.out[kTyre + i] = laws::tread_rate(
      e.p, e.p.axle(axle_of(i), Parameter::front_tyre_heat_capacity_jpk), e.s[kTyre + i],
      T(-(w.fx_n * w.slip_x_mps + w.fy_n * w.slip_y_mps)), norm(e.V), w.fz_n > T(0));
}

}  // namespace vehicle::dynamics
