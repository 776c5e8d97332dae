#include "identify/car_rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "vehicle/driver.h"
#include "vehicle/laws/brake_pads.h"
#include "vehicle/laws/engine.h"

namespace identify {
namespace {

using vehicle::Car, vehicle::Detail, vehicle::Inputs, vehicle::kWheels, vehicle::Simulation,
    vehicle::State;
using P = vehicle::Parameter;
using T = vehicle::Term;

constexpr double kYawLag_s = 0.08;
constexpr double kLongestWait = 4.0;  // for a balance, over the time of a stair
constexpr double kTrim_1ps = 40.0;    // how fast a slip angle follows the yaw moment

/// What is commanded: everything that the rig sets.
struct Pose {
  double front_rad = 0.0, rear_rad = 0.0, yaw_rate_radps = 0.0;
};

/// Cornering stiffness of both wheels of an axle, standing, N/rad.
double axle_stiffness(const Car<double>& car, std::size_t axle) {
  return 2.0 *
         std::abs(vehicle::tyre_stiffness(car.files->tyre[axle], car.static_load_n[axle],
                                          car.parameters.axle(axle, P::front_tyre_pressure_pa))
                      .cornering_npr);
}

/// Pressures that make the braking of the run, by the loads of the moment before.
void press_brakes(const Car<double>& car, const RigRun& run, double braking,
                  const Detail<double>& detail, Inputs<double>& in) {
  if (braking <= 0.0) return;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const std::size_t a = vehicle::axle_of(i);
    const double torque =
        braking * run.brake_axle[a] * detail.wheel[i].fz_n * car.static_radius_m[a];
    in.brake_pa[i] =
        torque / vehicle::laws::brake_torque(car.parameters.axle(a, P::front_brake_friction), 1.0,
                                             car.parameters.axle(a, P::front_brake_area_m2),
                                             car.parameters.axle(a, P::front_brake_radius_m));
  }
}

/// Puts the planar motion where the rig holds it.
void hold(const Car<double>& car, const RigRun& run, const Pose& pose, State<double>& s,
          Inputs<double>& in) {
  const double a = car.parameters[P::chassis_cog_behind_front_m];
  const double b = car.parameters[P::chassis_wheelbase_m] - a;
  s[vehicle::kX] = s[vehicle::kY] = s[vehicle::kYaw] = 0.0;
  s[vehicle::kVx] = run.speed_mps;
  s[vehicle::kYawRate] = pose.yaw_rate_radps;
  s[vehicle::kVy] = -std::tan(pose.rear_rad) * run.speed_mps + b * pose.yaw_rate_radps;
  in.steer_rad =
      pose.front_rad + std::atan((s[vehicle::kVy] + a * pose.yaw_rate_radps) / run.speed_mps);
}

void follow_path(const Car<double>& car, const RigRun& run, double share, double moment_nm,
                 Pose& pose) {
  const double a = car.parameters[P::chassis_cog_behind_front_m];
  const double b = car.parameters[P::chassis_wheelbase_m] - a;
  const double gain = kTrim_1ps * run.step_s;
  if (run.path == RigPath::kTrimRear) {
    pose.front_rad = std::clamp(pose.front_rad - gain * moment_nm / (a * axle_stiffness(car, 0)),
                                -0.1, std::abs(run.front_rad));
  } else {
    pose.front_rad = share * run.front_rad;
  }
  if (run.path == RigPath::kTrimFront) {
    pose.rear_rad = std::clamp(pose.rear_rad + gain * moment_nm / (b * axle_stiffness(car, 1)),
                               -0.1, std::abs(run.rear_rad));
  } else {
    pose.rear_rad = share * run.rear_rad;
  }
}

Simulation<double> begin(const Car<double>& car, double speed_mps, double fuel_kg) {
  vehicle::StartOptions options;
  options.speed_mps = speed_mps;
  options.fuel_kg = fuel_kg;
  options.gear = vehicle::choose_gear(car, speed_mps, vehicle::kMostGears);
  return vehicle::start(car, vehicle::Road(), options);
}

/// How far the stairs are at a step, and whether a moment is taken there.
struct Progress {
  double share = 0.0;
  bool shows = false;
};
Progress progress_of(const RigRun& run, std::size_t step) {
  const auto settle = static_cast<std::size_t>(run.settle_s / run.step_s);
  const auto stair = static_cast<std::size_t>(run.stair_s / run.step_s);
  if (step < settle) return {};
  const std::size_t at = (step - settle) / stair;
  return {static_cast<double>(at + 1) / static_cast<double>(run.stairs),
          (step - settle) % stair == stair - 1};
}

bool finite(const State<double>& s) {
  return std::all_of(s.value.begin(), s.value.end(), [](double x) { return std::isfinite(x); }) &&
         std::abs(s[vehicle::kRoll]) < 0.5 && std::abs(s[vehicle::kPitch]) < 0.5;
}

}  // namespace

CarMoment moment_of(const Car<double>& car, const State<double>& state, const State<double>& rate,
                    const Detail<double>& detail, double time_s) {
  using vehicle::dot;
  CarMoment out;
  out.time_s = time_s;
  vehicle::Vec3<double> normal;
  for (const auto& wheel : detail.wheel) normal += wheel.normal;
  normal = vehicle::unit(normal);
  const vehicle::Vec3<double> forward =
      vehicle::unit(vehicle::Vec3<double>{1.0, 0.0, 0.0} - normal.x * normal);
  const vehicle::Vec3<double> left = cross(normal, forward);
  const vehicle::Vec3<double> v{state[vehicle::kVx], state[vehicle::kVy], state[vehicle::kVz]};
  const vehicle::Vec3<double> turn{state[vehicle::kRollRate], state[vehicle::kPitchRate],
                                   state[vehicle::kYawRate]};
  out.vx_mps = dot(v, forward);
  out.vy_mps = dot(v, left);
  out.yaw_rate_radps = dot(turn, normal);
  out.steer_rad = detail.inputs.steer_rad;
  out.ax_mps2 = dot(detail.specific_force_mps2, forward);
  out.ay_mps2 = dot(detail.specific_force_mps2, left);
  out.an_mps2 = dot(detail.specific_force_mps2, normal);
  out.yaw_moment_nm = rate[vehicle::kYawRate] * car.parameters[P::chassis_yaw_inertia_kgm2];
  out.drive_nm = detail.wheel[2].drive_nm + detail.wheel[3].drive_nm;
  out.differential_nm = detail.differential_nm;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const auto& w = detail.wheel[i];
    const double along = std::max(1.0, std::abs(w.vx_mps));
    out.wheel[i] = {w.fx_n,       w.fy_n,       w.fz_n,   w.kappa,
                    w.camber_rad, w.spin_radps, w.vx_mps, w.slip_y_mps / along - w.tan_alpha};
    out.tyre_k[vehicle::axle_of(i)] += 0.5 * state[vehicle::kTyre + i];
  }
  return out;
}

Car<double> as_on_rig(const Car<double>& car, double gravity) {
  Car<double> out = car;
  for (const T term : {T::tyre_thermal, T::tyre_warm_up, T::fuel_burn, T::brake_heating,
                       T::brake_fade, T::wind, T::aero_slipstream})
    out.terms[term] = 0.0;
  out.parameters[P::environment_gravity_mps2] *= gravity;  // springs and loads stay as they stand
  return out;
}

std::vector<CarMoment> run_rig(const Car<double>& car_as_is, const RigRun& run) {
  const Car<double> car = as_on_rig(car_as_is, run.gravity);
  const vehicle::Road road;
  Simulation<double> sim = begin(car, run.speed_mps, run.fuel_kg);
  State<double>& s = sim.state;
  Detail<double> detail{};
  State<double> rate;
  Inputs<double> in;
  in.gear = run.neutral ? 0 : sim.discrete.gear;
  Pose pose;
  std::vector<CarMoment> out;
  const vehicle::StepOptions step{run.step_s, vehicle::Integrator::kSemiImplicit, false};
  const auto steps = static_cast<std::size_t>(
      (run.settle_s + run.stair_s * static_cast<double>(run.stairs)) / run.step_s);
  const auto longest = run.trim_nm > 0.0
                           ? static_cast<std::size_t>(kLongestWait * run.stair_s / run.step_s)
                           : std::size_t{0};
  std::size_t waited = 0, waited_here = 0;  // for the balance: in all, on this stair
  double moment_nm = 0.0;
  for (std::size_t k = 0; k - waited < steps; ++k) {
    const double time_s = static_cast<double>(k) * run.step_s;
    const Progress at = progress_of(run, k - waited);
    const double share = at.share;
    if (time_s >= run.settle_s) follow_path(car, run, share, moment_nm, pose);
    hold(car, run, pose, s, in);
    const double ready = std::min(1.0, time_s / (0.5 * run.settle_s));
    in.throttle = run.throttle_end < 0.0 ? run.throttle * ready
                                         : run.throttle + share * (run.throttle_end - run.throttle);
    press_brakes(car, run,
                 run.braking_end < 0.0 ? run.braking * ready
                                       : run.braking + share * (run.braking_end - run.braking),
                 detail, in);
    vehicle::derivative(car, s, in, road, sim.cursors, rate, detail);
    vehicle::settle_frictions(car, run.step_s, rate, detail);
    if (car.files->turbo == vehicle::Turbo::kFull) vehicle::settle_air(run.step_s, rate, detail);
    const CarMoment now = moment_of(car, s, rate, detail, time_s);
    moment_nm = now.yaw_moment_nm;
    const bool waits = at.shows && std::abs(moment_nm) > run.trim_nm && waited_here < longest;
    if (at.shows && !waits) out.push_back(now);
    waited += waits ? 1 : 0;
    // Where no balance came, there is none on later stairs either.
    waited_here = waits ? waited_here + 1 : (waited_here == longest ? longest : 0);
    pose.yaw_rate_radps +=
        run.step_s / kYawLag_s * (now.ay_mps2 / run.speed_mps - pose.yaw_rate_radps);
    for (const std::size_t i : {vehicle::kVx, vehicle::kVy, vehicle::kYawRate}) rate[i] = 0.0;
    vehicle::integrate(car, s, rate, detail, step);
    if (!finite(s)) break;
  }
  return out;
}

std::vector<CarMoment> run_swept_sine(const Car<double>& car_as_is, double speed_mps,
                                      double steer_rad, double seconds, double fuel_kg) {
  constexpr double kStep_s = 0.001, kSettle_s = 1.0, kLow_hz = 0.2, kHigh_hz = 4.0;
  const Car<double> car = as_on_rig(car_as_is, 1.0);
  const vehicle::Road road;
  Simulation<double> sim = begin(car, speed_mps, fuel_kg);
  Detail<double> detail{};
  State<double> rate;
  Inputs<double> in;
  in.gear = 0;
  std::vector<CarMoment> out;
  const auto steps = static_cast<std::size_t>((kSettle_s + seconds) / kStep_s);
  for (std::size_t k = 0; k < steps; ++k) {
    const double t = static_cast<double>(k) * kStep_s - kSettle_s;
    if (t >= 0.0)
      in.steer_rad = steer_rad * std::sin(2.0 * std::numbers::pi *
                                          (kLow_hz + 0.5 * (kHigh_hz - kLow_hz) * t / seconds) * t);
    const double mass = car.parameters[P::chassis_mass_kg] + fuel_kg;
    in.hold_n = detail.drag_n + 3.0 * mass * (speed_mps - sim.state[vehicle::kVx]);
    vehicle::derivative(car, sim.state, in, road, sim.cursors, rate, detail);
    vehicle::settle_frictions(car, kStep_s, rate, detail);
    if (car.files->turbo == vehicle::Turbo::kFull) vehicle::settle_air(kStep_s, rate, detail);
    if (t >= 0.0 && k % 10 == 0) out.push_back(moment_of(car, sim.state, rate, detail, t));
    vehicle::integrate(car, sim.state, rate, detail, {kStep_s});
    if (!finite(sim.state)) break;
  }
  return out;
}

double top_speed(const Car<double>& car) {
  const auto& p = car.parameters;
  const double drag =
      0.5 * p[P::aero_density_kgpm3] * p[P::aero_drag_area_m2] * car.terms[T::aero_drag];
  double v = 5.0;
  for (; v < 110.0; v += 0.5) {
    const int gear = vehicle::choose_gear(car, v, vehicle::kMostGears);
    const double ratio = vehicle::overall_ratio(p, gear);
    const double engine = ratio * v / car.static_radius_m[1];
    if (engine > p[P::engine_limit_radps]) break;
    const double force = vehicle::laws::map_torque(p[P::engine_torque], car.files->engine_torque_nm,
                                                   std::max(engine, p[P::clutch_full_radps]), 1.0) *
                         ratio * p[P::gearbox_efficiency] / car.static_radius_m[1];
    if (force < drag * v * v) break;
  }
  return v;
}

}  // namespace identify
