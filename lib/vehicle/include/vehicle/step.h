// One step of time: actuators with dead time, gear changes, then the continuous state.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "vehicle/dynamics.h"

namespace vehicle {

/// What a driver, a log or a script asks of the car.
template <class T>
struct Controls {
  T steer_command_rad = T(0);  ///< mean road wheel angle times steering.ratio
  T throttle_command = T(0);   ///< 0 to 1
  std::array<T, kWheels> brake_command_pa{};
  int gear_command = 1;  ///< 1 to 6, 0 neutral
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
  int gear = 1, gear_wanted = 1;
  double shift_left_s = 0.0;
  std::int64_t step = 0;  ///< steps taken; also the place in every ring
};

/// How the continuous state moves on. Either way frictions that can stick act implicitly on wheel
/// spin and engine speed (see Sticking): no explicit step resolves them.
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
    if (in.steer_rad > d.stuck_steer_rad + width) d.stuck_steer_rad = in.steer_rad - width;
    if (in.steer_rad < d.stuck_steer_rad - width) d.stuck_steer_rad = in.steer_rad + width;
    in.steer_rad = d.stuck_steer_rad;
  }
  in.throttle =
      through(d.throttle, Term::throttle_actuator,
              T(p[P::throttle_gain] * controls.throttle_command), P::throttle_dead_time_s);
  for (std::size_t i = 0; i < kWheels; ++i)
    in.brake_pa[i] =
        through(d.brake[i], Term::brake_actuator,
                T(p[P::brake_gain] * controls.brake_command_pa[i]), P::brake_dead_time_s);
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

/// Falls of the friction torques per slip speed, for one step: N m s. Where friction alone would
/// carry its slip through zero within the step, the fall is that of the friction which ends the
/// slip just there (a time-stepping contact law, J. J. Moreau, 1988); elsewhere it is the slope of
/// the regularised law. So a stick speed far too small for the step does not chatter.
template <class T>
struct Sticking {
  T clutch_nms = T(0), differential_nms = T(0);
  std::array<T, kWheels> brake_nms{};
};

template <class T>
Sticking<T> sticking(const Car<T>& car, const Detail<T>& detail, double step_s) {
  using P = Parameter;
  using std::abs;
  const Parameters<T>& p = car.parameters;
  const auto fall = [&](const T& slope, const T& torque, const T& slip, const T& inertia) {
    if (value_of(slip) == 0.0) return slope;
    const T ending = abs(torque / slip) - inertia / step_s;
    return ending > slope ? ending : slope;
  };
  Sticking<T> out;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const WheelDetail<T>& w = detail.wheel[i];
    out.brake_nms[i] = fall(w.brake_stiffness_nms, w.brake_nm, w.spin_radps,
                            p.axle(axle_of(i), P::front_wheel_inertia_kgm2));
  }
  const T& wheel = p[P::rear_wheel_inertia_kgm2];
  if (!is_exactly_zero(detail.gear_ratio)) {
    const T& ratio = detail.gear_ratio;
    const T through = 0.5 * ratio * ratio * detail.drive_efficiency / wheel;
    out.clutch_nms = fall(detail.clutch_stiffness_nms, detail.clutch_nm, detail.clutch_slip_radps,
                          T(1.0 / (1.0 / p[P::engine_inertia_kgm2] + through)));
  }
  out.differential_nms = fall(detail.differential_stiffness_nms, detail.differential_nm,
                              detail.differential_slip_radps, T(0.5 * wheel));
  return out;
}

/// Moves the continuous state on by one step with the derivative already evaluated.
template <class T>
void integrate(const Car<T>& car, State<T>& s, const State<T>& rate, const Detail<T>& detail,
               const StepOptions& options) {
  const double h = options.step_s;
  using P = Parameter;
  const Parameters<T>& p = car.parameters;

  // Engine and driven wheels: (1 - h J) change = h rate, with J the falls of clutch, differential
  // and brake friction; the front wheels only have their brakes.
  const Sticking<T> stick = sticking(car, detail, h);
  std::array<T, kWheels> spin_change;
  for (std::size_t i = 0; i < 2; ++i) {
    const T& inertia = p[P::front_wheel_inertia_kgm2];
    spin_change[i] = h * rate[kSpin + i] / (1.0 + h * stick.brake_nms[i] / inertia);
  }
  const T& inertia_w = p[P::rear_wheel_inertia_kgm2];
  const T& inertia_e = p[P::engine_inertia_kgm2];
  const T half = 0.5 * detail.gear_ratio;
  const T& c = stick.clutch_nms;
  const T& k = stick.differential_nms;
  const T e = detail.drive_efficiency;
  // Rows: engine, left, right. The engine's row is eliminated first.
  const T a00 = 1.0 + h * c / inertia_e;
  const T a01 = -h * c * half / inertia_e;
  const T a10 = -h * c * half * e / inertia_w;
  const T through = h * (c * half * half * e) / inertia_w;
  const T lock = h * k / inertia_w;
  const T fall_l = h * stick.brake_nms[2] / inertia_w;
  const T fall_r = h * stick.brake_nms[3] / inertia_w;
  const T b0 = h * rate[kEngine];
  const T eliminated = a10 * a01 / a00;
  const T m00 = 1.0 + through + lock + fall_l - eliminated;
  const T m11 = 1.0 + through + lock + fall_r - eliminated;
  const T m01 = through - lock - eliminated;
  const T r0 = h * rate[kSpin + 2] - a10 * b0 / a00;
  const T r1 = h * rate[kSpin + 3] - a10 * b0 / a00;
  const T determinant = m00 * m11 - m01 * m01;
  spin_change[2] = (r0 * m11 - m01 * r1) / determinant;
  spin_change[3] = (m00 * r1 - m01 * r0) / determinant;
  const T engine_change = (b0 - a01 * (spin_change[2] + spin_change[3])) / a00;

  if (options.integrator == Integrator::kExplicitEuler) {
    for (std::size_t i = 0; i < kStateSize; ++i)
      if (i != kEngine && (i < kSpin || i >= kSlipX)) s[i] += h * rate[i];
    for (std::size_t i = 0; i < kWheels; ++i) s[kSpin + i] += spin_change[i];
    s[kEngine] += engine_change;
    return;
  }

  const Vec3<T> dv{h * rate[kVx], h * rate[kVy], h * rate[kVz]};
  const Vec3<T> domega{h * rate[kRollRate], h * rate[kPitchRate], h * rate[kYawRate]};

  // Contact deflections, from the new velocities, with their decay at the end of the step.
  for (std::size_t i = 0; i < kWheels; ++i) {
    const WheelDetail<T>& w = detail.wheel[i];
    if (is_exactly_zero(car.terms[Term::tyre_relaxation])) continue;
    const Vec3<T> dcontact = dv + cross(domega, w.contact_m);
    const T dslip_x = dot(dcontact, w.heading) - spin_change[i] * w.rolling_radius_m;
    const T dslip_y = dot(dcontact, w.left);
    s[kSlipX + i] += h * (rate[kSlipX + i] - w.yield_x * dslip_x) / (1.0 + h * w.decay_x_1ps);
    s[kSlipY + i] += h * (rate[kSlipY + i] + w.yield_y * dslip_y) / (1.0 + h * w.decay_y_1ps);
  }

  // Place and attitude from the new velocities at the old attitude.
  const Rotation<T> R = rotation(s[kRoll], s[kPitch], s[kYaw]);
  const Vec3<T> dposition = R.apply(dv);
  using std::cos;
  using std::sin;
  const T cr = cos(s[kRoll]), sr = sin(s[kRoll]);
  const T dyaw = (domega.y * sr + domega.z * cr) / cos(s[kPitch]);
  s[kX] += h * (rate[kX] + dposition.x);
  s[kY] += h * (rate[kY] + dposition.y);
  s[kZ] += h * (rate[kZ] + dposition.z);
  const T droll = domega.x + dyaw * sin(s[kPitch]);
  s[kRoll] += h * (rate[kRoll] + droll);
  s[kPitch] += h * (rate[kPitch] + domega.y * cr - domega.z * sr);
  s[kYaw] += h * (rate[kYaw] + dyaw);
  for (std::size_t i = 0; i < kWheels; ++i) {
    s[kTravelRate + i] += h * rate[kTravelRate + i];
    s[kTravel + i] += h * s[kTravelRate + i];
    s[kSpin + i] += spin_change[i];
  }
  for (std::size_t i = kVx; i <= kYawRate; ++i) s[i] += h * rate[i];
  s[kEngine] += engine_change;
  for (std::size_t i = kTyre; i < kEngine; ++i) s[i] += h * rate[i];
  s[kBoost] += h * rate[kBoost];
  s[kFuel] += h * rate[kFuel];
  s[kPadHeat] += h * rate[kPadHeat];
  s[kTyreWarmth] += h * rate[kTyreWarmth];
}

/// One step: actuators, derivative, integration, and a look at the result. `detail` describes the
/// beginning of the step. Allocates nothing. On a problem the state is left as it came out, so that
/// the value that is not finite can be seen.
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
  if (options.gear >= 1 && options.gear <= 6) {
    const T ratio = car.parameters[P::gearbox_final] *
                    car.parameters[static_cast<P>(static_cast<std::size_t>(P::gearbox_ratio_1) +
                                                  static_cast<std::size_t>(options.gear) - 1)];
    const T turning = ratio * s[kSpin + 2];
    if (turning > engine) engine = turning;
  }
  s[kEngine] = engine;
  s[kFuel] = T(options.fuel_kg);
  return sim;
}

}  // namespace vehicle
