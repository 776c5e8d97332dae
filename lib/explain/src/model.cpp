#include "explain/model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/statistics.h"
#include "led_car.h"
#include "vehicle/car.h"
#include "vehicle/driver.h"
#include "vehicle/laws/actuator.h"
#include "vehicle/magic_formula.h"

namespace explain {
namespace {

using P = vehicle::Parameter;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kStep = Signals::kStep_s;

/// A series read earlier or later by `shift` steps, cubic between steps.
double at(const std::vector<double>& x, const std::vector<double>& dx, double place) {
  if (!(place >= 0) || place > static_cast<double>(x.size() - 1)) return kNaN;
  auto k = static_cast<std::size_t>(place);
  if (k + 1 >= x.size()) k = x.size() - 2;
  const double f = place - static_cast<double>(k);
  if (f == 0.0) return x[k];
  const double a = x[k], b = x[k + 1], da = dx[k] * kStep, db = dx[k + 1] * kStep;
  return a + f * (da + f * (3 * (b - a) - 2 * da - db + f * (2 * (a - b) + da + db)));
}

/// What the sensor would have said without its error.
void correct(const Signals& s, const Setting& set, Channel c, std::vector<double>& x,
             std::vector<double>& dx) {
  x = s.x[c];
  dx = s.dx[c];
  const Setting::Sensor& e = set.sensor[c];
  if (!s.present[c] || (e.bias == 0 && e.gain == 0 && e.delay_s == 0 && e.low_pass_s == 0)) return;
  const double gain = 1.0 / (1.0 + e.gain);
  std::vector<double> ddx(s.n, kNaN);
  for (std::size_t i = 1; i + 1 < s.n; ++i)
    ddx[i] = (s.dx[c][i + 1] - s.dx[c][i - 1]) / (2 * kStep);
  for (std::size_t i = 0; i < s.n; ++i) {
    const double place = static_cast<double>(i) + e.delay_s / kStep;
    double value = at(s.x[c], s.dx[c], place), rate = s.dx[c][i];
    if (e.delay_s != 0) rate = at(s.dx[c], ddx, place);
    // Beside a gap there is nothing to interpolate with; a value lost there would move the mask.
    if (std::isnan(value)) value = s.x[c][i] + e.delay_s * s.dx[c][i];
    if (std::isnan(rate)) rate = s.dx[c][i];
    if (e.low_pass_s != 0) {
      value += e.low_pass_s * rate;
      rate += e.low_pass_s * (i > 0 && i + 1 < s.n ? ddx[i] : kNaN);
    }
    x[i] = gain * (value - e.bias);
    dx[i] = gain * rate;
  }
}

std::vector<double> delayed(const std::vector<double>& x, double time_s) {
  if (time_s == 0) return x;
  std::vector<double> slope(x.size(), 0.0), out(x.size());
  for (std::size_t i = 1; i + 1 < x.size(); ++i) slope[i] = (x[i + 1] - x[i - 1]) / (2 * kStep);
  for (std::size_t i = 0; i < x.size(); ++i)
    out[i] = at(x, slope, std::max(0.0, static_cast<double>(i) - time_s / kStep));
  return out;
}

/// Where a driven wheel slips so much that its speed says nothing about a force any more: by the
/// log alone, with the radius that most of the log has.
std::vector<bool> spinning(const Signals& s, double track_m) {
  constexpr double kMost = 0.06;
  std::vector<bool> out(s.n, false);
  if (!s.present[kWheelRear]) return out;
  std::vector<double> radius_m;
  for (std::size_t i = 0; i < s.n; ++i)
    if (s.x[kVx][i] > 6.0 && std::isfinite(s.x[kWheelRear][i]))
      radius_m.push_back(s.x[kVx][i] / s.x[kWheelRear][i]);
  const double radius = base::median_or(1.0, std::move(radius_m));
  for (std::size_t i = 0; i < s.n; ++i) {
    const double v = s.x[kVx][i], r = s.present[kYawRate] ? s.x[kYawRate][i] : s.dx[kYaw][i];
    const double apart = s.present[kWheelRearDifference] ? s.x[kWheelRearDifference][i] : 0.0;
    for (const double left : {-1.0, 1.0}) {  // 1: the left wheel
      const double wheel = s.x[kWheelRear][i] + 0.5 * left * apart;
      const double over_ground = v - 0.5 * left * track_m * (std::isfinite(r) ? r : 0.0);
      out[i] = out[i] || wheel * radius > (1 + kMost) * over_ground;
    }
  }
  return out;
}

/// A profile at u; see RoadProfiles.
double profile_at(const std::vector<double>& profile, const Signals& s, double u_m) {
  if (profile.empty()) return 0.0;
  const std::size_t n = profile.size(), spaces = s.closed ? n : n - 1;
  const double place = std::clamp(u_m / s.length_m, 0.0, 1.0) * static_cast<double>(spaces);
  const std::size_t k = std::min(static_cast<std::size_t>(place), spaces - 1);
  const double f = place - static_cast<double>(k);
  return (1 - f) * profile[k] + f * profile[(k + 1) % n];
}

double positive(double x) { return x > 0 ? x : 0.0; }

/// Measured minus what the stated actuator makes of the command; NaN for a second after a gap.
void actuator_rows(std::vector<double>& out, const std::vector<double>& measured,
                   const std::vector<double>& command, double gain, double amplitude,
                   const vehicle::Parameters<double>& p, P dead_time) {
  constexpr int kSubsteps = 20;
  constexpr double kSubstep_s = kStep / kSubsteps;
  const double* const own = &p[dead_time];  // dead time, lag, damping, lead follow one another
  vehicle::laws::Actuator<double> actuator;
  std::int64_t step = 0;
  for (std::size_t i = 0; i + 1 < measured.size(); ++i) {
    const double from = gain * command[i], to = gain * command[i + 1];
    if (!std::isfinite(from) || !std::isfinite(to)) {
      step = 0;
      continue;
    }
    if (step == 0) {
      actuator.history.fill(from);
      actuator.place = from;
      actuator.rate = 0;
    }
    const double moved =
        amplitude == 0 || step == 0 ? from : actuator.place + own[3] * actuator.rate;
    if (step >= kSubsteps * 20) out[i] = measured[i] - (from + amplitude * (moved - from));
    // The command's mean over the substep that follows.
    for (int k = 0; k < kSubsteps; ++k)
      vehicle::laws::move(actuator, step++, from + (k + 0.5) / kSubsteps * (to - from), own[0],
                          own[1], own[2], own[3], kSubstep_s);
  }
}

/// The gear at every step, and where it is none or changes: the log's, the one whose ratio joins
/// engine and wheels, or the one that the car's driver would choose.
struct Gears {
  std::vector<int> gear;
  std::vector<bool> shifting;
};

Gears gears_of(const Signals& s, const vehicle::Vehicle& car, double radius_m) {
  const auto has = [&](Channel c) { return s.present[c]; };
  const vehicle::Parameters<double>& p = car.parameters;
  Gears out;
  out.gear.assign(s.n, 1);
  out.shifting.assign(s.n, false);
  vehicle::Car<double> shell;  // only for choose_gear
  shell.files = &car.files;
  shell.parameters = p;
  shell.terms = car.terms;
  shell.static_radius_m = {radius_m, radius_m};
  int now = 1;
  for (std::size_t i = 0; i < s.n; ++i) {
    const double speed = s.x[kVx][i];
    if (has(kGear)) {
      const double gear = s.x[kGear][i];
      bool shifting = !(gear >= 1 && gear <= 6);
      for (std::size_t k = i > 5 ? i - 5 : 0; k < std::min(s.n, i + 4); ++k)
        shifting = shifting || s.x[kGear][k] != gear;
      if (gear >= 1 && gear <= 6) now = static_cast<int>(gear);
      out.shifting[i] = shifting;
    } else if (has(kEngine) && std::isfinite(speed)) {
      // Between two gears the clutch is open.
      const double wheel = has(kWheelRear) ? s.x[kWheelRear][i] / (s.wheels_in_mps ? radius_m : 1.0)
                                           : speed / radius_m;
      const double ratio = s.x[kEngine][i] / std::max(1.0, wheel);
      double nearest = 1e300;
      int gear = now;
      for (int k = 1; k <= 6; ++k) {
        const double stated = vehicle::overall_ratio(p, k);
        const double off = stated > 0 ? std::abs(std::log(ratio / stated)) : 1e300;
        if (off < nearest) nearest = off, gear = k;
      }
      out.shifting[i] = !(nearest < 0.05);
      if (!out.shifting[i]) now = gear;
    } else if (std::isfinite(speed)) {
      now = vehicle::choose_gear(shell, speed, now);
    }
    out.gear[i] = now;
  }
  return out;
}

}  // namespace

std::vector<double> lagged(const std::vector<double>& x, double time_s) {
  if (time_s <= 0) return x;
  std::vector<double> out(x.size(), kNaN);
  const double keep = std::exp(-kStep / time_s);
  double state = kNaN, last = kNaN;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i])) continue;
    const double behind =
        std::isfinite(last) ? time_s * (x[i] - last) / kStep : 0.0;  // of a ramp, once settled
    state = std::isfinite(state) ? x[i] - behind + keep * (state - last + behind) : x[i];
    last = x[i];
    out[i] = state;
  }
  return out;
}

Acting& Setting::acting(const Effect& effect) {
  for (Acting& a : effects)
    if (a.effect == &effect) return a;
  effects.push_back({.effect = &effect});
  return effects.back();
}

void Setting::act(const Effect& effect, double amount, const std::array<double, 2>& constant) {
  Acting& a = acting(effect);
  a.amount[0] += amount;
  a.constant = constant;
}

const std::array<RelationInfo, kRelationCount>& relations() {
  static const std::array<RelationInfo, kRelationCount> list{
      {{"yaw_rate", "rad/s", true},
       {"course", "rad", true},
       {"speed", "m/s", true},
       {"front_wheels", "m/s", true},
       {"rear_wheels", "m/s", false},
       {"ax", "m/s2", true},
       {"ay", "m/s2", true},
       {"az", "m/s2", true},
       {"force_x", "m/s2", false},
       {"force_y", "m/s2", false},
       {"yaw_moment", "rad/s2", false},
       {"load_front", "N/kg", false},
       {"load_rear", "N/kg", false},
       {"rear_wheel_difference", "m/s", false},
       {"steering", "rad", true},
       {"throttle", "1", true},
       {"brake", "Pa", true}}};
  return list;
}

double typical_engine_radps(const std::vector<Signals>& logs, const vehicle::Vehicle& car) {
  std::vector<double> all;
  for (const Signals& s : logs) {
    const double radius_m = car.files.tyre[1].unloaded_radius_m;
    const Gears gears = gears_of(s, car, radius_m);
    for (std::size_t i = 0; i < s.n; ++i) {
      const double engine =
          s.present[kEngine]
              ? s.x[kEngine][i]
              : vehicle::overall_ratio(car.parameters, gears.gear[i]) * s.x[kVx][i] / radius_m;
      if (std::isfinite(engine) && s.x[kVx][i] > 6) all.push_back(engine);
    }
  }
  return base::median_or(car.parameters[P::turbo_reference_radps], std::move(all));
}

Residuals residuals(const Signals& s, const vehicle::Vehicle& car, const Setting& set,
                    const Drives& drives) {
  Residuals out;
  for (auto& r : out.r) r.assign(s.n, kNaN);
  const vehicle::Parameters<double>& p = set.p;
  std::array<std::vector<double>, kChannelCount> x, dx;
  for (std::size_t c = 0; c < kChannelCount; ++c)
    correct(s, set, static_cast<Channel>(c), x[c], dx[c]);
  const auto has = [&](Channel c) { return s.present[c]; };

  const double g = p[P::environment_gravity_mps2];
  const double a = p[P::chassis_cog_behind_front_m], wheelbase = p[P::chassis_wheelbase_m],
               b = wheelbase - a;
  std::array<double, 2> radius{};  // in which standing wheels roll
  for (std::size_t i = 0; i < 2; ++i)
    radius[i] =
        set.wheel_radius[i] * vehicle::standing_rolling_radius(
                                  car.files.tyre[i],
                                  p[P::chassis_mass_kg] * g * (i == 0 ? b : a) / (2 * wheelbase),
                                  p.axle(i, P::front_tyre_pressure_pa));
  const bool wheels_turn = has(kWheelFront) && !s.wheels_in_mps;
  const Gears gears = gears_of(s, car, radius[1]);

  Lead by;
  by.reserve_kg = set.burn * kStep * static_cast<double>(s.n);
  by.vy_known = has(kVy);
  by.gear = gears.gear;
  // Where command and outcome are logged, what comes late lies between them.
  const double steer_s = has(kSteerCommand) ? 0.0 : set.steer_s,
               steer_lag_s = has(kSteerCommand) ? 0.0 : set.steer_lag_s;
  const double throttle_s = has(kThrottleCommand) ? 0.0 : set.throttle_s,
               brake_s = has(kBrakeCommand) ? 0.0 : set.brake_s;
  by.steer = has(kSteer) ? lagged(delayed(x[kSteer], steer_s), steer_lag_s)
                         : std::vector<double>(s.n, kNaN);
  if (has(kThrottle)) by.throttle = delayed(x[kThrottle], throttle_s);
  if (has(kBrakeFront)) {
    by.brake_front_pa = delayed(x[kBrakeFront], brake_s);
    by.brake_rear_pa = delayed(x[kBrakeRear], brake_s);
  }
  if (has(kSteerCommand))
    actuator_rows(out.r[Relation::kSteering], x[kSteer],
                  lagged(delayed(x[kSteerCommand], set.steer_s), set.steer_lag_s),
                  1 / p[P::steering_ratio], car.terms[vehicle::Term::steering_actuator], p,
                  P::steering_dead_time_s);
  if (has(kThrottleCommand))
    actuator_rows(out.r[Relation::kThrottleMoves], x[kThrottle],
                  delayed(x[kThrottleCommand], set.throttle_s), p[P::throttle_gain],
                  car.terms[vehicle::Term::throttle_actuator], p, P::throttle_dead_time_s);
  if (has(kBrakeCommand))
    actuator_rows(out.r[Relation::kBrakeMoves], x[kBrakeFront],
                  delayed(x[kBrakeCommand], set.brake_s), p[P::brake_gain],
                  car.terms[vehicle::Term::brake_actuator], p, P::brake_dead_time_s);
  for (auto* v :
       {&by.vx_mps, &by.vy_mps, &by.yaw_radps, &by.yaw_rad, &by.gravity_mps2, &by.fuel_kg})
    v->assign(s.n, kNaN);

  std::vector<double> recorded_x(s.n, kNaN), recorded_y(s.n, kNaN), recorded_turn(s.n, kNaN);
  // Of an accelerometer that stands upright on the road.
  std::vector<double> at_x(s.n, kNaN), at_y(s.n, kNaN), upright(s.n, kNaN), pressed_on(s.n, kNaN);
  for (std::size_t i = 0; i < s.n; ++i) {
    // Where relations hold: decided by the log alone.
    const double speed0 = s.x[kVx][i];
    const bool placed = std::isfinite(s.u_m[i]) && speed0 > 6.0;
    if (!placed) continue;
    const double r = has(kYawRate) ? x[kYawRate][i] : dx[kYaw][i];
    const double dr = has(kYawRate) ? dx[kYawRate][i] : kNaN;
    const double vx = x[kVx][i], vy = has(kVy) ? x[kVy][i] - set.vy_ahead * r : 0.0;
    const double turning = set.vy_ahead != 0 && std::isfinite(dr) ? dr : 0.0;
    const double dvx = dx[kVx][i], dvy = has(kVy) ? dx[kVy][i] - set.vy_ahead * turning : 0.0;
    const double px = dx[kX][i], py = dx[kY][i];
    // Road, with what it may be wrong by; a shift reads the road a little earlier or later.
    double grade = s.grade[i], bank = s.bank[i], vertical = s.curvature_v[i];
    if (set.shift_u != 0 && i > 0 && i + 1 < s.n) {
      const double per = set.shift_u / (speed0 * 2 * kStep);
      const auto move = [&](const std::vector<double>& v) {
        return std::isfinite(v[i + 1] - v[i - 1]) ? per * (v[i + 1] - v[i - 1]) : 0.0;
      };
      grade += move(s.grade);
      bank += move(s.bank);
      vertical += move(s.curvature_v);
    }
    // Beside the middle of the road banking that changes along it is grade.
    const double beside = set.along.bank.empty() || !std::isfinite(s.v_m[i])
                              ? 0.0
                              : s.v_m[i] *
                                    (profile_at(set.along.bank, s, s.u_m[i] + 1.0) -
                                     profile_at(set.along.bank, s, s.u_m[i] - 1.0)) /
                                    2.0;
    // Of the road; along and across the car, which crosses it at an angle.
    const double course = std::atan2(py, px), across_it = std::sin(course - s.heading_rad[i]);
    const double up_along = set.grade + profile_at(set.along.grade, s, s.u_m[i]) + beside;
    const double up_across = set.bank + profile_at(set.along.bank, s, s.u_m[i]);
    grade += up_along + up_across * across_it;
    const double leaning_more = up_across - up_along * across_it;
    bank += leaning_more;
    vertical += set.vertical + profile_at(set.along.vertical, s, s.u_m[i]);
    // Of the angles whose tangents they are.
    const double cos_bank = 1 / std::sqrt(1 + bank * bank), sin_bank = bank * cos_bank;
    const double cos_grade = 1 / std::sqrt(1 + grade * grade), sin_grade = grade * cos_grade;

    // Sensors and kinematics.
    if (has(kYawRate)) {
      if (has(kYaw)) {
        out.r[Relation::kGyro][i] = r - dx[kYaw][i] * cos_bank * cos_grade;
      } else if (i > 1 && i + 2 < s.n) {
        const double before = std::atan2(dx[kY][i - 2], dx[kX][i - 2]),
                     after = std::atan2(dx[kY][i + 2], dx[kX][i + 2]);
        const double slip = has(kVy) ? (vx * dvy - vy * dvx) / (vx * vx) : 0.0;
        out.r[Relation::kGyro][i] =
            r - std::remainder(after - before, 2 * std::numbers::pi) / (4 * kStep) + slip;
      }
    }
    if (has(kYaw) && has(kVy))
      out.r[Relation::kCourse][i] = std::remainder(
          course - x[kYaw][i] - std::atan2(vy * cos_bank, vx * cos_grade), 2 * std::numbers::pi);
    out.r[Relation::kSpeed][i] = std::hypot(px, py) / cos_grade - std::hypot(vx, vy);
    const double brake_log = has(kBrakeFront) ? s.x[kBrakeFront][i] : 0.0;
    const double delta =
        has(kSteer) ? by.steer[i] / (s.commanded[kSteer] ? p[P::steering_ratio] : 1.0) : 0.0;
    if (has(kWheelFront) && !(brake_log > 3e4)) {
      const double factor = wheels_turn ? radius[0] : set.wheel_radius[0];
      const double at_wheel = vx * std::cos(delta) + (vy + a * r) * std::sin(delta);
      out.r[Relation::kFrontWheels][i] = x[kWheelFront][i] * factor - at_wheel;
    }
    // Specific force of the body: what an accelerometer in the centre of mass would say.
    // Without a logged side slip, that of the path over the heading.
    const double across =
        has(kVy) || !has(kYaw)
            ? vy
            : vx * std::tan(std::clamp(std::remainder(course - x[kYaw][i], 2 * std::numbers::pi),
                                       -0.3, 0.3));
    const double sfx = dvx - r * across + g * sin_grade;
    const double sfy = dvy + r * vx + g * sin_bank;
    // What presses on the road is its own curvature along the car, whatever the path's: the file's
    // heights were read along the car's tangent, from which a curved road's banking falls away.
    const double curved = vertical - leaning_more * s.line_curvature_1pm[i];
    const double pressed = (g * cos_grade + curved * vx * vx) * cos_bank;
    const double ahead = s.imu_ahead_m + set.imu_ahead;
    at_x[i] = sfx - ahead * r * r;
    at_y[i] = sfy + (std::isfinite(dr) ? ahead * dr : 0.0);
    upright[i] = g * cos_bank * cos_grade;
    pressed_on[i] = pressed;

    recorded_x[i] = sfx;
    recorded_y[i] = sfy;
    recorded_turn[i] = dr;
    by.vx_mps[i] = vx;
    if (has(kVy)) by.vy_mps[i] = vy;
    by.yaw_radps[i] = r;
    by.yaw_rad[i] = has(kYaw) ? x[kYaw][i] : course;
    by.gravity_mps2[i] = pressed;
    by.fuel_kg[i] = (has(kFuel) ? x[kFuel][i] : 0.0) - set.burn * kStep * static_cast<double>(i);
    // Without a logged steering the wheels point where the path goes.
    if (!has(kSteer)) by.steer[i] = std::atan(wheelbase * r / vx);
  }

  const auto accelerometer = [&](const Led& led) {
    const double cy = std::cos(s.imu_yaw_rad + set.imu_yaw),
                 sy = std::sin(s.imu_yaw_rad + set.imu_yaw);
    for (std::size_t i = 0; i < s.n; ++i) {
      // It rolls and pitches with the body. So does the gyro: what turning adds is in its reading.
      const auto angle = [&](const std::vector<double>& of) {
        return of.empty() || !std::isfinite(of[i]) ? 0.0 : of[i];
      };
      const double roll = (1 - set.level) * angle(led.roll_rad),
                   pitch = (1 - set.level) * angle(led.pitch_rad);
      const double leaning = roll * upright[i], diving = pitch * upright[i];
      const double felt_x = cy * (at_x[i] - diving) + sy * (at_y[i] + leaning);
      const double felt_y = cy * (at_y[i] + leaning) - sy * (at_x[i] - diving);
      // Measured, or the derivative of the speed under the name of an acceleration.
      if (has(kAx))
        out.r[Relation::kAccelX][i] =
            x[kAx][i] - (1 - set.derived_ax) * felt_x - set.derived_ax * dx[kVx][i];
      if (has(kAy) && has(kVy)) out.r[Relation::kAccelY][i] = x[kAy][i] - felt_y;
      if (has(kAz))
        out.r[Relation::kAccelZ][i] = x[kAz][i] - pressed_on[i] + roll * at_y[i] - pitch * at_x[i];
    }
  };
  // Without a brake in the log only what is driven says what drives.
  std::vector<bool> driven(s.n, has(kThrottle));
  for (std::size_t i = 0; i < s.n && !has(kBrakeFront); ++i)
    for (std::size_t k = i > 4 ? i - 4 : 0; k < std::min(s.n, i + 5); ++k)
      driven[i] = driven[i] && s.x[kThrottle][k] > 0.15;
  const auto along = [&](const Led& led) {
    for (std::size_t i = 0; i < s.n; ++i)
      if (driven[i] && !gears.shifting[i])
        out.r[Relation::kForceX][i] = recorded_x[i] - led.force_x_mps2[i];
  };
  if (drives.none) {
    accelerometer(drives.known != nullptr ? drives.known->led : Led{});
    if (drives.known != nullptr) along(drives.known->led);
    return out;
  }

  // What lib/vehicle's car would do there.
  const bool known = drives.known != nullptr && same_drive(*drives.known, set, by);
  const Led led = known ? drives.known->led : lead(s, car, set, by);
  if (drives.keep != nullptr) *drives.keep = {set, by, led};
  accelerometer(led);
  along(led);
  const double mass0 = p[P::chassis_mass_kg];
  const std::vector<bool> spins = spinning(s, car.parameters[P::rear_track_m]);
  for (std::size_t i = 0; i < s.n; ++i) {
    const bool braking = has(kBrakeFront) && s.x[kBrakeFront][i] > 3e4;
    if (has(kVy) && has(kSteer)) {
      out.r[Relation::kForceY][i] = recorded_y[i] - led.force_y_mps2[i];
      // Times the inertia over that stated and the mass alone: no inertia and no mass can make its
      // error small.
      out.r[Relation::kMomentZ][i] =
          (recorded_turn[i] - led.yaw_radps2[i]) * p[P::chassis_yaw_inertia_kgm2] /
          car.parameters[P::chassis_yaw_inertia_kgm2] * car.parameters[P::chassis_mass_kg] / mass0;
    }
    if (has(kLoadFront))
      out.r[Relation::kLoadsFront][i] = (x[kLoadFront][i] - led.load_front_n[i]) / mass0;
    if (has(kLoadRear))
      out.r[Relation::kLoadsRear][i] = (x[kLoadRear][i] - led.load_rear_n[i]) / mass0;
    if (!driven[i] || gears.shifting[i] || braking || spins[i]) continue;
    const double rolling_m =
        s.wheels_in_mps ? radius[1] / set.wheel_radius[1] : led.rear_rolling_m[i];
    const double share = s.wheels_in_mps ? set.wheel_radius[1] : rolling_m;
    if (has(kWheelRear))
      out.r[Relation::kRearWheels][i] = x[kWheelRear][i] * share - led.rear_radps[i] * rolling_m;
    if (has(kWheelRearDifference))
      out.r[Relation::kDifferential][i] =
          x[kWheelRearDifference][i] * share - led.rear_difference_radps[i] * rolling_m;
  }
  return out;
}

Regimes regimes(const Signals& s) {
  Regimes out;
  for (auto* v : {&out.speed, &out.ax, &out.ay, &out.throttle, &out.brake}) v->assign(s.n, kNaN);
  for (std::size_t i = 0; i < s.n; ++i) {
    out.speed[i] = s.x[kVx][i];
    out.ax[i] = s.dx[kVx][i];
    out.ay[i] = s.x[kVx][i] * (s.present[kYawRate] ? s.x[kYawRate][i] : s.dx[kYaw][i]);
    out.throttle[i] = s.x[kThrottle][i];
    out.brake[i] = s.present[kBrakeFront] ? positive(s.x[kBrakeFront][i]) : 0.0;
  }
  return out;
}

}  // namespace explain
