// What each relation leaves over at a setting: first what needs no car, then what the car that is
// led along the recording has.
#include "relations.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "actuator_rows.h"
#include "base/statistics.h"
#include "further_along.h"
#include "standing_car.h"
#include "vehicle/magic_formula.h"
#include "where_known.h"

namespace explain {
namespace {

using P = vehicle::Parameter;
constexpr double kAny = std::numeric_limits<double>::infinity();
constexpr double kBraking_pa = 3e4;  ///< less is the logger's noise

/// A profile at u; see RoadProfiles.
double profile_at(const std::vector<double>& profile, const Signals& s, double u_m) {
  if (profile.empty()) return 0.0;
  const std::size_t n = profile.size(), spaces = s.closed ? n : n - 1;
  const double place = std::clamp(u_m / s.length_m, 0.0, 1.0) * static_cast<double>(spaces);
  const std::size_t k = std::min(static_cast<std::size_t>(place), spaces - 1);
  const double f = place - static_cast<double>(k);
  return (1 - f) * profile[k] + f * profile[(k + 1) % n];
}

/// The cosine of the angle whose tangent it is.
double cosine_of(double slope) { return 1 / std::sqrt(1 + slope * slope); }

}  // namespace

Relations::Relations(const Signals& s, const vehicle::Vehicle& car, const Setting& set)
    : s_(s), car_(car), set_(set), c_(corrected_channels(s, set)) {
  for (auto& r : out_.r) r.assign(s.n, kNaN);
  for (auto* v :
       {&recorded_x_, &recorded_y_, &recorded_turn_, &at_x_, &at_y_, &upright_, &pressed_on_})
    v->assign(s.n, kNaN);
  const double g = set.p[P::environment_gravity_mps2];
  const double a = set.p[P::chassis_cog_behind_front_m];
  const double wheelbase = set.p[P::chassis_wheelbase_m], b = wheelbase - a;
  for (std::size_t i = 0; i < 2; ++i)
    radius_[i] =
        set.wheel_radius[i] *
        vehicle::standing_rolling_radius(
            car.files.tyre[i], set.p[P::chassis_mass_kg] * g * (i == 0 ? b : a) / (2 * wheelbase),
            set.p.axle(i, P::front_tyre_pressure_pa));
  const double stiffness_n =
      vehicle::tyre_forces(
          car.files.tyre[0],
          vehicle::TyreInput<double>{.fz_n = standing_load_n(car, 0), .vx_mps = 30.0}, {},
          {.moments = false})
          .slip_stiffness_n;
  if (stiffness_n > 0)
    front_slip_per_mps2_ =
        car.parameters[P::front_wheel_inertia_kgm2] / (radius_[0] * radius_[0] * stiffness_n);
  gears_ = gears_of(s, car, radius_[1]);
  driven_ = where_driven(s);
  pushed_as_led_ = where_pushed_as_led(s, driven_);
  slip_known_ = where_slip_known(s);
}

void Relations::compare_commands() {
  using vehicle::Term;
  const auto& p = set_.p;
  const auto& x = c_.x;
  if (has(kSteerCommand))
    actuator_rows(out_.r[Relation::kSteering], x[kSteer],
                  lagged(delayed(x[kSteerCommand], set_.steer_s), set_.steer_lag_s),
                  1 / p[P::steering_ratio], kAny, car_.terms[Term::steering_actuator], p,
                  P::steering_dead_time_s);
  if (has(kThrottleCommand))
    actuator_rows(out_.r[Relation::kThrottleMoves], x[kThrottle],
                  delayed(x[kThrottleCommand], set_.throttle_s), p[P::throttle_gain], 1.0,
                  car_.terms[Term::throttle_actuator], p, P::throttle_dead_time_s);
  if (has(kBrakeCommand))
    actuator_rows(out_.r[Relation::kBrakeMoves], x[kBrakeFront],
                  delayed(x[kBrakeCommand], set_.brake_s),
                  set_.pressure_by_command * car_.parameters[P::brake_gain], kAny,
                  car_.terms[Term::brake_actuator], p, P::brake_dead_time_s);
}

void Relations::begin_lead() {
  const auto& x = c_.x;
  by_.reserve_kg = set_.burn * Signals::kStep_s * static_cast<double>(s_.n);
  by_.vy_known = has(kVy);
  by_.gear = gears_.gear;
  // Where command and outcome are logged, what comes late lies between them.
  const double steer_s = has(kSteerCommand) ? 0.0 : set_.steer_s,
               steer_lag_s = has(kSteerCommand) ? 0.0 : set_.steer_lag_s;
  const double throttle_s = has(kThrottleCommand) ? 0.0 : set_.throttle_s,
               brake_s = has(kBrakeCommand) ? 0.0 : set_.brake_s;
  by_.steer = has(kSteer) ? lagged(delayed(x[kSteer], steer_s), steer_lag_s)
                          : std::vector<double>(s_.n, kNaN);
  if (has(kThrottle)) by_.throttle = delayed(x[kThrottle], throttle_s);
  if (has(kBrakeFront)) {
    by_.brake_front_pa = delayed(x[kBrakeFront], brake_s);
    by_.brake_rear_pa = delayed(x[kBrakeRear], brake_s);
    if (has(kBrakeFrontApart)) by_.brake_front_apart_pa = delayed(x[kBrakeFrontApart], brake_s);
    if (has(kBrakeRearApart)) by_.brake_rear_apart_pa = delayed(x[kBrakeRearApart], brake_s);
  }
  for (auto* v :
       {&by_.vx_mps, &by_.vy_mps, &by_.yaw_radps, &by_.yaw_rad, &by_.gravity_mps2, &by_.fuel_kg})
    v->assign(s_.n, kNaN);
}

Motion Relations::motion(std::size_t i) const {
  const auto &x = c_.x, &dx = c_.dx;
  Motion m;
  m.yaw = has(kYawRate) ? x[kYawRate][i] : dx[kYaw][i];
  if (has(kYawRate)) m.dyaw = dx[kYawRate][i];
  m.vx = x[kVx][i];
  m.vy = has(kVy) ? x[kVy][i] - set_.vy_ahead * m.yaw : 0.0;
  const double turning = set_.vy_ahead != 0 && std::isfinite(m.dyaw) ? m.dyaw : 0.0;
  m.dvx = dx[kVx][i];
  m.dvy = has(kVy) ? dx[kVy][i] - set_.vy_ahead * turning : 0.0;
  m.px = dx[kX][i];
  m.py = dx[kY][i];
  const double swing_mps = set_.place_ahead * dx[kYaw][i];
  if (set_.place_ahead != 0 && std::isfinite(swing_mps)) {  // an antenna ahead swings out in turns
    m.px += swing_mps * std::sin(x[kYaw][i]);
    m.py -= swing_mps * std::cos(x[kYaw][i]);
  }
  return m;
}

/// Without a logged side slip, that of the path over the heading; else none.
double Relations::lateral_mps(std::size_t i, const Motion& m, const Slope& road) const {
  if (has(kVy) || !has(kYaw)) return m.vy;
  const double slip_rad = std::remainder(road.course_rad - c_.x[kYaw][i], 2 * std::numbers::pi);
  return m.vx * std::tan(std::clamp(slip_rad, -0.3, 0.3));
}

Slope Relations::slope(std::size_t i, const Motion& m) const {
  Slope out;
  out.grade = s_.grade[i], out.bank = s_.bank[i], out.vertical = s_.curvature_v[i];
  // A shift reads the road where the car was, or will be, that much further along.
  if (set_.shift_u != 0) {
    const auto move = [&](const std::vector<double>& v, double& to) {
      if (const double there = at_step(v, shifted_[i]); std::isfinite(there)) to = there;
    };
    move(s_.grade, out.grade);
    move(s_.bank, out.bank);
    move(s_.curvature_v, out.vertical);
  }
  // Beside the middle of the road banking that changes along it is grade.
  const double beside = set_.along.bank.empty() || !std::isfinite(s_.v_m[i])
                            ? 0.0
                            : s_.v_m[i] *
                                  (profile_at(set_.along.bank, s_, s_.u_m[i] + 1.0) -
                                   profile_at(set_.along.bank, s_, s_.u_m[i] - 1.0)) /
                                  2.0;
  // Of the road; along and across the car, which crosses it at an angle.
  out.course_rad = std::atan2(m.py, m.px);
  const double across_it = std::sin(out.course_rad - s_.heading_rad[i]);
  const double up_along = set_.grade + profile_at(set_.along.grade, s_, s_.u_m[i]) + beside;
  const double up_across = set_.bank + profile_at(set_.along.bank, s_, s_.u_m[i]);
  out.grade += up_along + up_across * across_it;
  out.leaning_more = up_across - up_along * across_it;
  out.bank += out.leaning_more;
  out.vertical += set_.vertical + profile_at(set_.along.vertical, s_, s_.u_m[i]);
  // All this is along the path. On a leaning road a nose that points into the turn climbs.
  const double slip_rad = std::atan2(lateral_mps(i, m, out), m.vx);
  const double sin_slip = std::sin(slip_rad), cos_slip = std::cos(slip_rad);
  out.path_grade = out.grade;
  out.grade = out.path_grade * cos_slip - out.bank * sin_slip;
  out.bank = out.bank * cos_slip + out.path_grade * sin_slip;
  return out;
}

void Relations::compare_kinematics(std::size_t i, const Motion& m, const Slope& road) {
  const auto &x = c_.x, &dx = c_.dx;
  const double cos_bank = cosine_of(road.bank), cos_grade = cosine_of(road.grade);
  // The path alone turns as the car and the angle between them do.
  if (has(kYawRate) && (has(kYaw) || has(kVy))) {
    double turning = kNaN;  // on the map
    if (has(kYaw)) {
      turning = dx[kYaw][i];
    } else if (i > 1 && i + 2 < s_.n) {
      const double before = std::atan2(dx[kY][i - 2], dx[kX][i - 2]),
                   after = std::atan2(dx[kY][i + 2], dx[kX][i + 2]);
      const double slip = (m.vx * m.dvy - m.vy * m.dvx) / (m.vx * m.vx);
      turning =
          std::remainder(after - before, 2 * std::numbers::pi) / (4 * Signals::kStep_s) - slip;
    }
    // The rate about the axis of a body that leans with the road, from its angles on the map.
    out_.r[Relation::kGyro][i] =
        m.yaw - turning * cos_bank * cos_grade - road.pitching_up_radps * road.bank * cos_bank;
  }
  if (has(kYaw) && has(kVy))
    out_.r[Relation::kCourse][i] =
        std::remainder(road.course_rad - x[kYaw][i] - std::atan2(m.vy * cos_bank, m.vx * cos_grade),
                       2 * std::numbers::pi);
  out_.r[Relation::kSpeed][i] =
      std::hypot(m.px, m.py) / cosine_of(road.path_grade) - std::hypot(m.vx, m.vy);
  const bool rolls = has(kBrakeFront) ? !(s_.x[kBrakeFront][i] > kBraking_pa) : pushed_as_led_[i];
  if (!has(kWheelFront) || !rolls || !slip_known_[i]) return;
  const double delta =
      has(kSteer) ? by_.steer[i] / (s_.commanded[kSteer] ? set_.p[P::steering_ratio] : 1.0) : 0.0;
  const double factor = s_.wheels_in_mps ? set_.wheel_radius[0] : radius_[0];
  const double a = set_.p[P::chassis_cog_behind_front_m];
  const double left_mps = lateral_mps(i, m, road) + a * m.yaw;
  // The tyre that spins its wheel up slips.
  const double at_wheel =
      (m.vx * std::cos(delta) + left_mps * std::sin(delta)) * (1 - front_slip_per_mps2_ * m.dvx);
  out_.r[Relation::kFrontWheels][i] = x[kWheelFront][i] * factor - at_wheel;
}

void Relations::record(std::size_t i, const Motion& m, const Slope& road) {
  const auto& x = c_.x;
  const double g = set_.p[P::environment_gravity_mps2];
  const double cos_bank = cosine_of(road.bank), sin_bank = road.bank * cos_bank;
  const double cos_grade = cosine_of(road.grade), sin_grade = road.grade * cos_grade;
  // Specific force of the body: what an accelerometer in the centre of mass would say.
  const double across = lateral_mps(i, m, road);
  const double sfx = m.dvx - m.yaw * across + g * sin_grade;
  const double sfy = m.dvy + m.yaw * m.vx + g * sin_bank;
  // What presses on the road is its own curvature along the car, whatever the path's: the file's
  // heights were read along the car's tangent, from which a curved road's banking falls away.
  const double curved = road.vertical - road.leaning_more * s_.line_curvature_1pm[i];
  const double pressed = (g * cos_grade + curved * m.vx * m.vx) * cos_bank;
  const double ahead = s_.imu_ahead_m + set_.imu_ahead;
  at_x_[i] = sfx - ahead * m.yaw * m.yaw;
  at_y_[i] = sfy + (std::isfinite(m.dyaw) ? ahead * m.dyaw : 0.0);
  upright_[i] = g * cos_bank * cos_grade;
  pressed_on_[i] = pressed;

  recorded_x_[i] = sfx;
  recorded_y_[i] = sfy;
  recorded_turn_[i] = m.dyaw;
  by_.vx_mps[i] = m.vx;
  if (has(kVy)) by_.vy_mps[i] = m.vy;
  by_.yaw_radps[i] = m.yaw;
  by_.yaw_rad[i] = has(kYaw) ? x[kYaw][i] : road.course_rad;
  by_.gravity_mps2[i] = pressed;
  by_.fuel_kg[i] =
      (has(kFuel) ? x[kFuel][i] : 0.0) - set_.burn * Signals::kStep_s * static_cast<double>(i);
  // Without a logged steering the wheels point where the path goes.
  if (!has(kSteer)) by_.steer[i] = std::atan(set_.p[P::chassis_wheelbase_m] * m.yaw / m.vx);
}

void Relations::compare_motion() {
  begin_lead();
  if (set_.shift_u != 0) shifted_ = further_along(s_, set_.shift_u);
  // Where relations hold: decided by the log alone.
  const auto holds = [&](std::size_t i) {
    return i < s_.n && std::isfinite(s_.u_m[i]) && s_.x[kVx][i] > 6.0;
  };
  std::vector<Slope> road(s_.n);
  for (std::size_t i = 0; i < s_.n; ++i)
    if (holds(i)) road[i] = slope(i, motion(i));
  for (std::size_t i = 0; i < s_.n; ++i) {
    if (!holds(i)) continue;
    if (i > 0 && holds(i - 1) && holds(i + 1))
      road[i].pitching_up_radps =
          (std::atan(road[i + 1].grade) - std::atan(road[i - 1].grade)) / (2 * Signals::kStep_s);
    const Motion m = motion(i);
    compare_kinematics(i, m, road[i]);
    record(i, m, road[i]);
  }
}

void Relations::compare_accelerometer(const Led& led) {
  const auto &x = c_.x, &dx = c_.dx;
  const double cy = std::cos(s_.imu_yaw_rad + set_.imu_yaw),
               sy = std::sin(s_.imu_yaw_rad + set_.imu_yaw);
  for (std::size_t i = 0; i < s_.n; ++i) {
    // It rolls and pitches with the body. So does the gyro: what turning adds is in its reading.
    const auto angle = [&](const std::vector<double>& of) {
      return of.empty() || !std::isfinite(of[i]) ? 0.0 : of[i];
    };
    const double roll = (1 - set_.level) * angle(led.roll_rad),
                 pitch = (1 - set_.level) * angle(led.pitch_rad);
    const double leaning = roll * upright_[i], diving = pitch * upright_[i];
    const double felt_x = cy * (at_x_[i] - diving) + sy * (at_y_[i] + leaning);
    const double felt_y = cy * (at_y_[i] + leaning) - sy * (at_x_[i] - diving);
    // Measured, or the derivative of the speed under the name of an acceleration.
    if (has(kAx) && slip_known_[i])
      out_.r[Relation::kAccelX][i] =
          x[kAx][i] - (1 - set_.derived_ax) * felt_x - set_.derived_ax * dx[kVx][i];
    if (has(kAy) && has(kVy)) out_.r[Relation::kAccelY][i] = x[kAy][i] - felt_y;
    if (has(kAz))
      out_.r[Relation::kAccelZ][i] =
          x[kAz][i] - pressed_on_[i] + roll * at_y_[i] - pitch * at_x_[i];
  }
}

void Relations::compare_force_along(const Led& led) {
  // Nobody knows what boost an engine had before a log begins, or where it goes on after a gap.
  constexpr auto kForgotten = static_cast<std::size_t>(1.0 / Signals::kStep_s);
  std::size_t led_for = 0;
  for (std::size_t i = 0; i < s_.n; ++i) {
    led_for = std::isfinite(led.force_x_mps2[i]) ? led_for + 1 : 0;
    if (driven_[i] && !gears_.shifting[i] && slip_known_[i] && led_for > kForgotten)
      out_.r[Relation::kForceX][i] = recorded_x_[i] - led.force_x_mps2[i];
  }
}

void Relations::compare_forces(const Led& led) {
  compare_force_along(led);
  const auto& p = set_.p;
  const auto& x = c_.x;
  const double mass0 = p[P::chassis_mass_kg];
  const std::vector<bool> spins = where_spinning(s_, car_.parameters[P::rear_track_m]);
  for (std::size_t i = 0; i < s_.n; ++i) {
    const bool braking = has(kBrakeFront) && s_.x[kBrakeFront][i] > kBraking_pa;
    // After a shift the clutch drags at the driven wheels, which then steer less; the car that is
    // led has none.
    if (has(kVy) && has(kSteer) && !gears_.shifting[i] && pushed_as_led_[i]) {
      out_.r[Relation::kForceY][i] = recorded_y_[i] - led.force_y_mps2[i];
      // Times the inertia over that stated and the mass alone: no inertia and no mass can make its
      // error small.
      out_.r[Relation::kMomentZ][i] = (recorded_turn_[i] - led.yaw_radps2[i]) *
                                      p[P::chassis_yaw_inertia_kgm2] /
                                      car_.parameters[P::chassis_yaw_inertia_kgm2] *
                                      car_.parameters[P::chassis_mass_kg] / mass0;
    }
    if (has(kLoadFront) && pushed_as_led_[i])
      out_.r[Relation::kLoadsFront][i] = (x[kLoadFront][i] - led.load_front_n[i]) / mass0;
    if (has(kLoadRear) && pushed_as_led_[i])
      out_.r[Relation::kLoadsRear][i] = (x[kLoadRear][i] - led.load_rear_n[i]) / mass0;
    if (!driven_[i] || gears_.shifting[i] || braking || spins[i] || !slip_known_[i]) continue;
    const double rolling_m =
        s_.wheels_in_mps ? radius_[1] / set_.wheel_radius[1] : led.rear_rolling_m[i];
    const double share = s_.wheels_in_mps ? set_.wheel_radius[1] : rolling_m;
    if (has(kWheelRear))
      out_.r[Relation::kRearWheels][i] = x[kWheelRear][i] * share - led.rear_radps[i] * rolling_m;
    if (has(kWheelRearDifference))
      out_.r[Relation::kDifferential][i] =
          x[kWheelRearDifference][i] * share - led.rear_difference_radps[i] * rolling_m;
  }
}

}  // namespace explain
