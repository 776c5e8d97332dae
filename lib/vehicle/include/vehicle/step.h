// One step of time: actuators with dead time, gear changes, then the continuous state.
#pragma once

#include <cmath>
#include <string>
#include <utility>

#include "vehicle/energy.h"
#include "vehicle/ledges.h"
#include "vehicle/settle.h"
#include "vehicle/start.h"

namespace vehicle {

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

inline constexpr double kFastest_mps = 1000.0, kFarthestTilt_rad = 1.4;

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

/// Adds h times their rate to the states that states.def says so of.
template <class T, std::size_t... I>
void move_by_rate(State<T>& s, const State<T>& rate, double h, std::index_sequence<I...>) {
  const auto move = [&]<std::size_t i>() {
    if constexpr (kStates[i].moves == Moves::kByRate) s[i] += h * rate[i];
  };
  (move.template operator()<I>(), ...);
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
  move_by_rate(s, rate, h, std::make_index_sequence<kStateSize>());
  for (std::size_t i = 0; i < kWheels; ++i) s[kTravel + i] += h * s[kTravelRate + i];
}

/// What is wrong with a state that a step has led to.
template <class T>
StepResult judge(const State<T>& s) {
  for (std::size_t i = 0; i < kStateSize; ++i)
    if (!std::isfinite(value_of(s[i]))) return {StepResult::Problem::kNotFinite, i};
  // No car is that fast: numbers that will soon not be finite.
  for (std::size_t i = kVx; i <= kVz; ++i)
    if (std::abs(value_of(s[i])) > kFastest_mps) return {StepResult::Problem::kRanAway, i};
  // Euler angles end at 90 degrees of pitch; a car ends before.
  if (std::abs(value_of(s[kPitch])) > kFarthestTilt_rad ||
      std::abs(value_of(s[kRoll])) > kFarthestTilt_rad)
    return {StepResult::Problem::kRolledOver, 0};
  return {};
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
  settle_ledges(car, options.step_s, sim.state, sim.discrete.ledge, sim.discrete.ledges, rate,
                detail);
  integrate(car, sim.state, rate, detail, options);
  sim.time_s = static_cast<double>(sim.discrete.step) * options.step_s;
  return judge(sim.state);
}

// As derivative().
extern template StepResult step(const Car<double>&, Simulation<double>&, const Controls<double>&,
                                const Road&, const StepOptions&, Detail<double>&);

}  // namespace vehicle
