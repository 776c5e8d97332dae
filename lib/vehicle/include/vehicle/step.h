// One step of time: actuators with dead time, gear changes, then the continuous state.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "vehicle/dynamics.h"
#include "vehicle/energy.h"
#include "vehicle/laws/actuator_friction.h"

namespace vehicle {

/// What a driver, a log or a script asks of the car.
template <class T>
struct Controls {
  T steer_command_rad = T(0);  ///< mean road wheel angle times steering.ratio
  T throttle_command = T(0);   ///< 0 to 1
  std::array<T, kWheels> brake_command_pa{};
  int gear_command = 1;  ///< 1 to 6, 0 neutral, -1 reverse
  T hold_n = T(0);       ///< see Inputs
  bool opponent = false;
  T wake_x_m = T(0), wake_y_m = T(0);  ///< the opponent in this car's body frame
};

/// A command on its way through dead time and a second-order transfer function.
template <class T>
struct Actuator {
  static constexpr std::size_t kCapacity = 512;  ///< longest dead time, in steps, plus two
  std::array<T, kCapacity> history{};            ///< ring of commands
  T place = T(0), rate = T(0);                   ///< of the second-order system, rate per second
};

/// What changes only between steps.
template <class T>
struct Discrete {
  Actuator<T> steer, throttle;
  std::array<Actuator<T>, kWheels> brake;
  T stuck_steer_rad = T(0);  ///< where friction holds the steering
  T last_steer_rad = T(0);   ///< of the step before
  laws::Stick<T> steer_stick;  ///< the same with a break-away
  T played_steer_rad = T(0);   ///< where backlash leaves the road wheels
  std::array<laws::Stick<T>, kWheels> brake_stick;
  int gear = 1, gear_wanted = 1;
  double shift_left_s = 0.0;
  std::int64_t step = 0;  ///< steps taken; also the place in every ring
};

/// How the continuous state moves on. Either way frictions that can stick act with their torque at
/// the end of the step (see settle_frictions): no explicit step resolves them.
enum class Integrator {
  kExplicitEuler,  ///< every rate from the old state
  kSemiImplicit    ///< velocities first, then positions from the new velocities; contact deflection
                   ///< implicitly against its own decay
};

struct StepOptions {
  double step_s = 0.001;
  Integrator integrator = Integrator::kSemiImplicit;
  bool stop_off_road = false;  ///< a wheel over a hole or beside the grid ends the run; otherwise
                               ///< the car goes on over the nearest valid height
};

/// The whole of a running car; trivially copyable when T is: a copy is a restart point.
template <class T>
struct Simulation {  // NOLINT(clang-analyzer-optin.performance.Padding): read in this order
  State<T> state;
  Discrete<T> discrete;
  RoadCursors cursors;
  double time_s = 0.0;
};

/// How a step ended.
struct StepResult {
  enum class Problem { kNone, kNotFinite, kRanAway, kNoRoad, kRolledOver } problem = Problem::kNone;
  std::size_t index = 0;  ///< the state (kNotFinite, kRanAway) or the wheel (kNoRoad) concerned
  bool ok() const { return problem == Problem::kNone; }
};

/// One sentence about a failed step: what, when, where.
std::string describe(const StepResult& result, double time_s, double u_m, double v_m);

/// Throws Error when a dead time does not fit the actuators' rings at this step.
void check_step(const Parameters<double>& parameters, const StepOptions& options);

namespace step_detail {

/// What one step of length h makes of (deviation from the command, rate) of an actuator: exact for
/// a command held over the step.
template <class T>
struct Transition {
  T m00, m01, m10, m11;
};

/// Of lag^2 y'' + 2 damping lag y' + y = command. Its trace and determinant are the coefficients of
/// the ARX model that the actuator is at this step.
template <class T>
Transition<T> actuator_transition(const T& lag_s, const T& damping, double step_s) {
  using std::cos;
  using std::exp;
  using std::sin;
  using std::sqrt;
  const T x = step_s / lag_s;
  const T q = (1.0 - damping * damping) * x * x;  // square of the angle turned in a step
  const T fade = damping * x;
  T c, s;  // exp(-fade) cos(sqrt q), exp(-fade) sin(sqrt q) / sqrt q
  if (q < T(0.01) && q > T(-0.01)) {
    const T e = exp(-fade);
    c = e * (1.0 - q / 2.0 * (1.0 - q / 12.0 * (1.0 - q / 30.0 * (1.0 - q / 56.0))));
    s = e * (1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0 * (1.0 - q / 72.0))));
  } else if (q > T(0)) {
    const T e = exp(-fade), angle = sqrt(q);
    c = e * cos(angle);
    s = e * sin(angle) / angle;
  } else {  // two real poles; both exponents are negative, so nothing overflows
    const T angle = sqrt(-q), slow = exp(angle - fade), fast = exp(-angle - fade);
    c = 0.5 * (slow + fast);
    s = 0.5 * (slow - fast) / angle;
  }
  return {c + fade * s, s * step_s, -s * x / lag_s, c - fade * s};
}

/// Command to output. `amplitude` 0 is not called: the caller passes the command on.
template <class T>
T move(Actuator<T>& actuator, std::int64_t step, const T& command, const T& dead_time_s,
       const T& lag_s, const T& damping, const T& lead_s, double step_s) {
  constexpr auto kCapacity = static_cast<std::int64_t>(Actuator<T>::kCapacity);
  const auto ring = [&](std::int64_t back) -> T& {
    return actuator
        .history[static_cast<std::size_t>(((step - back) % kCapacity + kCapacity) % kCapacity)];
  };
  ring(0) = command;
  // A dead time between two steps mixes the two, so that its derivative exists.
  const T delay = dead_time_s / step_s;
  auto whole = static_cast<std::int64_t>(value_of(delay));
  if (whole > kCapacity - 2) whole = kCapacity - 2;
  const T part = delay - static_cast<double>(whole);
  const T delayed = ring(whole) + part * (ring(whole + 1) - ring(whole));
  if (value_of(lag_s) <= 0.0) {
    actuator.place = delayed;
    actuator.rate = T(0);
  } else {
    const Transition<T> m = actuator_transition(lag_s, damping, step_s);
    const T away = actuator.place - delayed, rate = actuator.rate;
    actuator.place = delayed + m.m00 * away + m.m01 * rate;
    actuator.rate = m.m10 * away + m.m11 * rate;
  }
  return actuator.place + lead_s * actuator.rate;
}

}  // namespace step_detail

/// Moves actuators and gearbox on by one step and returns what the car gets during it.
template <class T>
Inputs<T> actuate(const Car<T>& car, Discrete<T>& d, const Controls<T>& controls, double step_s) {
  using P = Parameter;
  const Parameters<T>& p = car.parameters;
  // The four parameters of an actuator follow one another in the list.
  const auto through = [&](Actuator<T>& actuator, Term term, const T& command, P dead_time) {
    if (is_exactly_zero(car.terms[term])) return command;
    const T* const own = &p[dead_time];  // dead time, lag, damping, lead
    const T moved =
        step_detail::move(actuator, d.step, command, own[0], own[1], own[2], own[3], step_s);
    return T(command + car.terms[term] * (moved - command));
  };
  Inputs<T> in;
  in.steer_rad =
      through(d.steer, Term::steering_actuator,
              T(controls.steer_command_rad / p[P::steering_ratio]), P::steering_dead_time_s);
  if (!is_exactly_zero(car.terms[Term::steering_friction])) {
    // The wheels stay where they are until the actuator is ahead of them by the friction width.
    const T width = car.terms[Term::steering_friction] * p[P::steering_friction_rad];
    if (is_exactly_zero(p[P::steering_breakaway_rad])) {
      laws::play(in.steer_rad, width, d.stuck_steer_rad);
      in.steer_rad = d.stuck_steer_rad;
    } else {
      laws::stick(in.steer_rad, width,
                  T(car.terms[Term::steering_friction] * p[P::steering_breakaway_rad]),
                  d.steer_stick);
      in.steer_rad = d.steer_stick.output;
    }
  }
  if (!is_exactly_zero(car.terms[Term::steering_backlash]) &&
      !is_exactly_zero(p[P::steering_backlash_rad])) {
    laws::play(in.steer_rad,
               T(0.5 * car.terms[Term::steering_backlash] * p[P::steering_backlash_rad]),
               d.played_steer_rad);
    in.steer_rad = d.played_steer_rad;
  }
  in.steer_rate_radps = d.step == 0 ? T(0) : T((in.steer_rad - d.last_steer_rad) / step_s);
  d.last_steer_rad = in.steer_rad;
  in.throttle =
      through(d.throttle, Term::throttle_actuator,
              T(p[P::throttle_gain] * controls.throttle_command), P::throttle_dead_time_s);
  for (std::size_t i = 0; i < kWheels; ++i)
    in.brake_pa[i] =
        through(d.brake[i], Term::brake_actuator,
                T(p[P::brake_gain] * controls.brake_command_pa[i]), P::brake_dead_time_s);
  const bool sticks =
      !is_exactly_zero(car.terms[Term::brake_friction]) &&
      (!is_exactly_zero(p[P::brake_friction_pa]) || !is_exactly_zero(p[P::brake_breakaway_pa]));
  for (std::size_t i = 0; i < kWheels && sticks; ++i) {
    laws::stick(in.brake_pa[i], T(car.terms[Term::brake_friction] * p[P::brake_friction_pa]),
                T(car.terms[Term::brake_friction] * p[P::brake_breakaway_pa]), d.brake_stick[i]);
    in.brake_pa[i] = d.brake_stick[i].output;
  }
  in.hold_n = controls.hold_n;
  in.opponent = controls.opponent;
  in.wake_x_m = controls.wake_x_m;
  in.wake_y_m = controls.wake_y_m;

  if (controls.gear_command != d.gear_wanted) {
    d.gear_wanted = controls.gear_command;
    d.shift_left_s = value_of(p[P::gearbox_shift_s]);
  }
  // Half a step of tolerance, so that a shift takes the same number of steps on every machine.
  if (d.shift_left_s > 0.5 * step_s) {
    d.gear = 0;
    d.shift_left_s -= step_s;
  } else {
    d.gear = d.gear_wanted;
  }
  in.gear = d.gear;
  in.next_gear = d.gear == 0 ? d.gear_wanted : 0;
  ++d.step;
  return in;
}

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
  using P = Parameter;
  using std::abs;
  const Parameters<T>& p = car.parameters;
  const double h = step_s;
  const auto clip = [](const T& x, const T& most) {
    return x > most ? most : (x < -most ? -most : x);
  };
  std::array<T, kWheels> spin_rate;
  std::array<T, kWheels> brake_nm;

  // Front wheels: nothing but their brakes.
  for (std::size_t i = 0; i < 2; ++i) {
    const WheelDetail<T>& w = detail.wheel[i];
    const T& inertia = p[P::front_wheel_inertia_kgm2];
    const T others_nm = inertia * rate[kSpin + i] - w.brake_nm;
    brake_nm[i] = clip(T(-inertia * w.spin_radps / h - others_nm), w.brake_capacity_nm);
    spin_rate[i] = (others_nm + brake_nm[i]) / inertia;
  }

  // Engine and driven wheels: (1 - h J) change = h rate, with J the falls of clutch and
  // differential friction per slip speed.
  const T& inertia_w = p[P::rear_wheel_inertia_kgm2];
  const T& inertia_e = p[P::engine_inertia_kgm2];
  const T e = detail.drive_efficiency;
  const T half = 0.5 * detail.gear_ratio;
  const auto fall = [&](const T& slope, const T& torque, const T& slip, const T& inertia) {
    if (value_of(slip) == 0.0) return slope;
    const T ending = abs(torque / slip) - inertia / h;
    return ending > slope ? ending : slope;
  };
  T c = T(0);
  if (!is_exactly_zero(detail.gear_ratio))
    c = fall(detail.clutch_stiffness_nms, detail.clutch_nm, detail.clutch_slip_radps,
             T(1.0 / (1.0 / inertia_e + 2.0 * half * half * e / inertia_w)));
  // Rows: engine, left, right. The engine's row is eliminated first.
  const T a00 = 1.0 + h * c / inertia_e;
  const T a01 = -h * c * half / inertia_e;
  const T a10 = -h * c * half * e / inertia_w;
  const T through = h * (c * half * half * e) / inertia_w;
  const T b0 = h * rate[kEngine];
  const T eliminated = a10 * a01 / a00;
  // Without brakes; every newton metre of a brake adds h / inertia.
  std::array<T, 2> free, change;
  for (std::size_t i = 0; i < 2; ++i) {
    const WheelDetail<T>& w = detail.wheel[2 + i];
    free[i] = h * (rate[kSpin + 2 + i] - w.brake_nm / inertia_w) - a10 * b0 / a00;
  }
  // The mean of both wheels does not see the differential: it gives the clutch torque of the step,
  // on which the limited slip depends.
  T differential_nm = detail.differential_nm, slope = detail.differential_stiffness_nms;
  if (!is_exactly_zero(detail.limited_slip_nm)) {
    const T both = (free[0] + free[1] +
                    h / inertia_w * (detail.wheel[2].brake_nm + detail.wheel[3].brake_nm)) /
                   (1.0 + 2.0 * (through - eliminated));
    const T clutch_nm = detail.clutch_nm + c * ((b0 - a01 * both) / a00 - half * both);
    const T more_nm =
        laws::limited_slip_torque(p, car.terms[Term::limited_slip],
                                  T(clutch_nm * detail.gear_ratio * e)) -
        detail.limited_slip_nm;
    const T& grip = detail.limited_slip_grip;
    differential_nm += more_nm * grip;
    slope += more_nm * (1.0 - grip * grip) / p[P::differential_stick_radps];
    free[0] -= h / inertia_w * more_nm * grip;
    free[1] += h / inertia_w * more_nm * grip;
  }
  const T k = fall(slope, differential_nm, detail.differential_slip_radps, T(0.5 * inertia_w));
  const T lock = h * k / inertia_w;
  const T m0 = 1.0 + through + lock - eliminated;
  const T m1 = through - lock - eliminated;
  // A brake slides with all it has, or holds its wheel with what that takes. At most one of both
  // decisions changes in a round.
  std::array<bool, 2> holds{}, slides{};
  for (std::size_t i = 0; i < 2; ++i) {
    const WheelDetail<T>& w = detail.wheel[2 + i];
    const double spin = value_of(w.spin_radps);
    slides[i] = !(value_of(w.brake_capacity_nm) > 0.0);
    holds[i] = !slides[i] && spin == 0.0;
    brake_nm[2 + i] = spin > 0.0 ? T(-w.brake_capacity_nm) : w.brake_capacity_nm;
  }
  for (int round = 0; round < 5; ++round) {
    const auto right = [&](std::size_t i) { return free[i] + h / inertia_w * brake_nm[2 + i]; };
    const auto stop = [&](std::size_t i) { return T(-detail.wheel[2 + i].spin_radps); };
    if (holds[0] && holds[1]) {
      change = {stop(0), stop(1)};
    } else if (holds[0]) {
      change[0] = stop(0);
      change[1] = (right(1) - m1 * change[0]) / m0;
    } else if (holds[1]) {
      change[1] = stop(1);
      change[0] = (right(0) - m1 * change[1]) / m0;
    } else {
      const T determinant = m0 * m0 - m1 * m1;
      change[0] = (right(0) * m0 - m1 * right(1)) / determinant;
      change[1] = (m0 * right(1) - m1 * right(0)) / determinant;
    }
    bool done = true;
    for (std::size_t i = 0; i < 2 && done; ++i) {
      const WheelDetail<T>& w = detail.wheel[2 + i];
      if (holds[i]) {
        const T needed_nm = (m0 * change[i] + m1 * change[1 - i] - free[i]) * inertia_w / h;
        brake_nm[2 + i] = clip(needed_nm, w.brake_capacity_nm);
        slides[i] = abs(needed_nm) > w.brake_capacity_nm;
        holds[i] = !slides[i];
        done = holds[i];
      } else if (!slides[i] && w.spin_radps * (w.spin_radps + change[i]) <= T(0)) {
        holds[i] = true;
        done = false;
      }
    }
    if (done) break;
  }
  spin_rate[2] = change[0] / h;
  spin_rate[3] = change[1] / h;
  const T engine_change = (b0 - a01 * (change[0] + change[1])) / a00;
  rate[kEngine] = engine_change / h;
  const T clutch_nm = detail.clutch_nm + c * (engine_change - half * (change[0] + change[1]));
  differential_nm += k * (change[0] - change[1]);
  const T driven_nm = clutch_nm * detail.gear_ratio * e;
  detail.clutch_nm = clutch_nm;
  detail.differential_nm = differential_nm;
  detail.wheel[2].drive_nm = 0.5 * driven_nm - differential_nm;
  detail.wheel[3].drive_nm = 0.5 * driven_nm + differential_nm;

  // The body takes the reaction of every torque that differs from the state's.
  Vec3<T> moment;
  for (std::size_t i = 0; i < kWheels; ++i) {
    detail.wheel[i].brake_nm = brake_nm[i];
    const T& inertia = p.axle(axle_of(i), P::front_wheel_inertia_kgm2);
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

/// Moves the continuous state on by one step with its rates, frictions settled.
template <class T>
void integrate(const Car<T>& car, State<T>& s, const State<T>& rate, const Detail<T>& detail,
               const StepOptions& options) {
  const double h = options.step_s;
  if (options.integrator == Integrator::kExplicitEuler) {
    for (std::size_t i = 0; i < kStateSize; ++i) s[i] += h * rate[i];
    return;
  }

  const Vec3<T> dv{h * rate[kVx], h * rate[kVy], h * rate[kVz]};
  const Vec3<T> domega{h * rate[kRollRate], h * rate[kPitchRate], h * rate[kYawRate]};

  // Contact deflections, from the new velocities, with their decay at the end of the step.
  for (std::size_t i = 0; i < kWheels; ++i) {
    const WheelDetail<T>& w = detail.wheel[i];
    if (is_exactly_zero(car.terms[Term::tyre_relaxation])) continue;
    const Vec3<T> dcontact = dv + cross(domega, w.contact_m);
    const T dslip_x = dot(dcontact, w.heading) - h * rate[kSpin + i] * w.rolling_radius_m;
    const T dslip_y = dot(dcontact, w.left);
    s[kSlipX + i] += h * (rate[kSlipX + i] - w.yield_x * dslip_x) / (1.0 + h * w.decay_x_1ps);
    s[kSlipY + i] += h * (rate[kSlipY + i] + w.yield_y * dslip_y) / (1.0 + h * w.decay_y_1ps);
  }

  // Place and attitude from the new velocities at the old attitude.
  const Attitude<T> a = attitude(s[kRoll], s[kPitch], s[kYaw]);
  const Vec3<T> dposition = rotation(a).apply(dv);
  const T &cr = a.cos_roll, &sr = a.sin_roll;
  const T dyaw = (domega.y * sr + domega.z * cr) / a.cos_pitch;
  s[kX] += h * (rate[kX] + dposition.x);
  s[kY] += h * (rate[kY] + dposition.y);
  s[kZ] += h * (rate[kZ] + dposition.z);
  const T droll = domega.x + dyaw * a.sin_pitch;
  s[kRoll] += h * (rate[kRoll] + droll);
  s[kPitch] += h * (rate[kPitch] + domega.y * cr - domega.z * sr);
  s[kYaw] += h * (rate[kYaw] + dyaw);
  for (std::size_t i = 0; i < kWheels; ++i) {
    s[kTravelRate + i] += h * rate[kTravelRate + i];
    s[kTravel + i] += h * s[kTravelRate + i];
    s[kSpin + i] += h * rate[kSpin + i];
  }
  for (std::size_t i = kVx; i <= kYawRate; ++i) s[i] += h * rate[i];
  for (std::size_t i = kTyre; i <= kEngine; ++i) s[i] += h * rate[i];
  s[kBoost] += h * rate[kBoost];
  s[kFuel] += h * rate[kFuel];
  s[kPadHeat] += h * rate[kPadHeat];
  s[kTyreWarmth] += h * rate[kTyreWarmth];
  for (std::size_t i = kManifold; i <= kTurbo; ++i) s[i] += h * rate[i];
}

/// One step: actuators, derivative, integration, and a look at the result. `detail` describes the
/// beginning of the step, with the friction torques of the step. Allocates nothing. On a problem
/// the state is left as it came out, so that the value that is not finite can be seen.
template <class T>
StepResult step(const Car<T>& car, Simulation<T>& sim, const Controls<T>& controls,
                const Road& road, const StepOptions& options, Detail<T>& detail) {
  const Inputs<T> in = actuate(car, sim.discrete, controls, options.step_s);
  State<T> rate;
  derivative(car, sim.state, in, road, sim.cursors, rate, detail);
  for (std::size_t i = 0; i < kWheels; ++i)
    if (!std::isfinite(detail.wheel[i].road.z_m) ||
        (options.stop_off_road && !detail.wheel[i].road.on_road))
      return {StepResult::Problem::kNoRoad, i};
  settle_frictions(car, options.step_s, rate, detail);
  if (car.files->turbo == Turbo::kFull) settle_air(options.step_s, rate, detail);
  integrate(car, sim.state, rate, detail, options);
  sim.time_s = static_cast<double>(sim.discrete.step) * options.step_s;
  for (std::size_t i = 0; i < kStateSize; ++i)
    if (!std::isfinite(value_of(sim.state[i]))) return {StepResult::Problem::kNotFinite, i};
  // No car is that fast: numbers that will soon not be finite.
  for (std::size_t i = kVx; i <= kVz; ++i)
    if (std::abs(value_of(sim.state[i])) > 1000.0) return {StepResult::Problem::kRanAway, i};
  // Euler angles end at 90 degrees of pitch; a car ends before.
  if (std::abs(value_of(sim.state[kPitch])) > 1.4 || std::abs(value_of(sim.state[kRoll])) > 1.4)
    return {StepResult::Problem::kRolledOver, 0};
  return {};
}

/// A car at rest or rolling straight at `speed_mps` in `gear`, design height above `road` at
/// (x, y), level with the road, wheels and engine turning to match, everything at the temperatures
/// given. Not yet in exact balance: fuel and downforce still settle.
struct StartOptions {
  double x_m = 0.0, y_m = 0.0, yaw_rad = 0.0;
  double z_near_m = std::numeric_limits<double>::quiet_NaN();  ///< which level of a bridge
  double speed_mps = 0.0;
  int gear = 1;
  double fuel_kg = 30.0;
  double tyre_k = 360.0;
  double disc_k = 500.0;
};

template <class T>
Simulation<T> start(const Car<T>& car, const Road& road, const StartOptions& options) {
  using P = Parameter;
  using std::sqrt;
  Simulation<T> sim{};
  const RoadPoint ground = road.at(options.x_m, options.y_m, options.z_near_m, 0, sim.cursors);
  const double cy = std::cos(options.yaw_rad), sy = std::sin(options.yaw_rad);
  const double along = ground.dzdx * cy + ground.dzdy * sy;
  const double across = -ground.dzdx * sy + ground.dzdy * cy;
  const double pitch = -std::atan(along);
  const double roll = std::atan(across * std::cos(pitch));
  const double height = value_of(car.parameters[P::chassis_cog_height_m]);
  State<T>& s = sim.state;
  for (T& value : s.value) value = T(0);
  const Rotation<double> R = rotation(roll, pitch, options.yaw_rad);
  s[kX] = T(options.x_m + height * R.z.x);
  s[kY] = T(options.y_m + height * R.z.y);
  s[kZ] = T(ground.z_m + height * R.z.z);
  s[kRoll] = T(roll);
  s[kPitch] = T(pitch);
  s[kYaw] = T(options.yaw_rad);
  s[kVx] = T(options.speed_mps);
  for (std::size_t i = 0; i < kWheels; ++i) {
    const std::size_t a = axle_of(i);
    const TyreCoefficients& tyre = car.files->tyre[a];
    const double deflection = tyre.unloaded_radius_m * tyre.qre0 - value_of(car.static_radius_m[a]);
    const double radius = rolling_radius(tyre, value_of(car.static_load_n[a]),
                                         tyre.unloaded_radius_m * tyre.qre0, deflection);
    s[kSpin + i] = T(options.speed_mps / radius);
    s[kTyre + i] = T(options.tyre_k);
    s[kDiscSurface + i] = T(options.disc_k);
    s[kDiscCore + i] = T(options.disc_k);
  }
  sim.discrete.gear = sim.discrete.gear_wanted = options.gear;
  T engine = car.parameters[P::engine_idle_radps];
  if (options.gear != 0) {
    const T ratio = overall_ratio(car.parameters, options.gear);
    const T turning = ratio * s[kSpin + 2];
    if (turning > engine) engine = turning;
  }
  s[kEngine] = engine;
  s[kFuel] = T(options.fuel_kg);
  if (car.files->turbo == Turbo::kFull) {
    // Throttle closed: what leaks through chokes, the cylinders take it; the turbocharger idles.
    const Parameters<T>& p = car.parameters;
    const T air_k = p[P::environment_temperature_k];
    const T air_pa = p[P::aero_density_kgpm3] * laws::kGas * air_k;
    const T sucked = p[P::engine_filling] * p[P::engine_displacement_m3] * engine /
                     (4.0 * 3.141592653589793 * sqrt(laws::kGas * air_k));
    const T manifold = std::sqrt(0.5) * p[P::intake_leak_m2] * air_pa / sucked;
    s[kManifold] = manifold < 0.5 * air_pa ? manifold : T(0.5 * air_pa);
    s[kCharge] = s[kExhaust] = air_pa;
    s[kTurbo] = T(1000);
  }
  return sim;
}

}  // namespace vehicle
