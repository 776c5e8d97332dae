#include "explain/model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "vehicle/driver.h"
#include "vehicle/laws/aero.h"
#include "vehicle/laws/boost.h"
#include "vehicle/laws/brake_pads.h"
#include "vehicle/laws/driveline.h"
#include "vehicle/laws/engine.h"
#include "vehicle/laws/tyre_warm_up.h"
#include "vehicle/magic_formula.h"

namespace explain {
namespace {

using P = vehicle::Parameter;
namespace laws = vehicle::laws;
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
void correct(const Signals& s, const Setting& set, Channel c, std::vector<double>& x, std::vector<double>& dx) {
  x = s.x[c];
  dx = s.dx[c];
  const Setting::Sensor& e = set.sensor[c];
  if (!s.present[c] || (e.bias == 0 && e.gain == 0 && e.delay_s == 0 && e.low_pass_s == 0)) return;
  const double gain = 1.0 / (1.0 + e.gain);
  std::vector<double> ddx(s.n, kNaN);
  for (std::size_t i = 1; i + 1 < s.n; ++i) ddx[i] = (s.dx[c][i + 1] - s.dx[c][i - 1]) / (2 * kStep);
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

/// First-order lag, exact for what is straight between steps; starts settled, holds over gaps.
std::vector<double> lagged(const std::vector<double>& x, double time_s) {
  if (time_s <= 0) return x;
  std::vector<double> out(x.size(), kNaN);
  const double keep = std::exp(-kStep / time_s);
  double state = kNaN, last = kNaN;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i])) continue;
    const double behind = std::isfinite(last) ? time_s * (x[i] - last) / kStep : 0.0;  // of a ramp, once settled
    state = std::isfinite(state) ? x[i] - behind + keep * (state - last + behind) : x[i];
    last = x[i];
    out[i] = state;
  }
  return out;
}

std::vector<double> delayed(const std::vector<double>& x, double time_s) {
  if (time_s == 0) return x;
  std::vector<double> slope(x.size(), 0.0), out(x.size());
  for (std::size_t i = 1; i + 1 < x.size(); ++i) slope[i] = (x[i + 1] - x[i - 1]) / (2 * kStep);
  for (std::size_t i = 0; i < x.size(); ++i)
    out[i] = at(x, slope, std::max(0.0, static_cast<double>(i) - time_s / kStep));
  return out;
}

double positive(double x) { return x > 0 ? x : 0.0; }

}  // namespace

const std::array<RelationInfo, kRelationCount>& relations() {
  static const std::array<RelationInfo, kRelationCount> list{{{"yaw_rate", "rad/s", true},
                                                              {"course", "rad", true},
                                                              {"speed", "m/s", true},
                                                              {"front_wheels", "m/s", true},
                                                              {"rear_wheels", "m/s", true},
                                                              {"ax", "m/s2", true},
                                                              {"ay", "m/s2", true},
                                                              {"az", "m/s2", true},
                                                              {"force_x", "m/s2", false},
                                                              {"force_y", "m/s2", false},
                                                              {"yaw_moment", "rad/s2", false},
                                                              {"load_front", "N/kg", false},
                                                              {"load_rear", "N/kg", false},
                                                              {"rear_wheel_difference", "m/s", false}}};
  return list;
}

Residuals residuals(const Signals& s, const vehicle::Vehicle& car, const Setting& set) {
  Residuals out;
  for (auto& r : out.r) r.assign(s.n, kNaN);
  const vehicle::Parameters<double>& p = set.p;
  std::array<std::vector<double>, kChannelCount> x, dx;
  for (std::size_t c = 0; c < kChannelCount; ++c) correct(s, set, static_cast<Channel>(c), x[c], dx[c]);
  const auto has = [&](Channel c) { return s.present[c]; };

  // What reaches the car: commands go through the stated actuators first, measurements do not.
  const auto through = [&](Channel c, vehicle::Term term, P dead, P lag, double more_s, double gain) {
    std::vector<double> y = x[c];
    if (s.commanded[c]) {
      for (double& v : y) v *= gain;
      const double amount = car.terms[term];
      more_s += amount * p[dead];
      y = lagged(lagged(delayed(y, more_s), amount * p[lag]), amount * p[lag]);
    } else {
      y = delayed(y, more_s);
    }
    return y;
  };
  std::vector<double> steer = through(kSteer, vehicle::Term::steering_actuator, P::steering_dead_time_s,
                                      P::steering_lag_s, set.steer_s, 1.0 / p[P::steering_ratio]);
  steer = lagged(steer, set.steer_lag_s);
  const std::vector<double> throttle = through(kThrottle, vehicle::Term::throttle_actuator, P::throttle_dead_time_s,
                                               P::throttle_lag_s, set.throttle_s, 1.0);
  const std::vector<double> brake_front = through(kBrakeFront, vehicle::Term::brake_actuator, P::brake_dead_time_s,
                                                  P::brake_lag_s, set.brake_s, 1.0);
  const std::vector<double> brake_rear = through(kBrakeRear, vehicle::Term::brake_actuator, P::brake_dead_time_s,
                                                 P::brake_lag_s, set.brake_s, 1.0);

  const double g = p[P::environment_gravity_mps2];
  const double mass0 = p[P::chassis_mass_kg];
  const double a = p[P::chassis_cog_behind_front_m], wheelbase = p[P::chassis_wheelbase_m], b = wheelbase - a;
  const double h = p[P::chassis_cog_height_m];
  const std::array<double, 2> track{p.axle(0, P::front_track_m), p.axle(1, P::front_track_m)};
  std::array<double, 2> roll{}, radius{}, load0{}, roll_spring{};
  for (std::size_t i = 0; i < 2; ++i) {
    roll_spring[i] = p.axle(i, P::front_spring_npm) + 2 * p.axle(i, P::front_anti_roll_npm);
    roll[i] = 0.5 * roll_spring[i] * track[i] * track[i];
    load0[i] = mass0 * g * (i == 0 ? b : a) / (2 * wheelbase);
    radius[i] = set.wheel_radius[i] * vehicle::standing_rolling_radius(car.files.tyre[i], load0[i], p.axle(i, P::front_tyre_pressure_pa));
  }
  const double roll_share_front = roll[0] / (roll[0] + roll[1]);
  // What the car remembers from one step to the next.
  double boost = 0.0, pad_heat_j = 0.0;
  std::array<double, 2> last_alpha{kNaN, kNaN};
  double warmth = 0.0;
  const double cold_loss = car.terms[vehicle::Term::tyre_warm_up] * p[P::tyre_warm_up_loss], cold = cold_loss + set.thermal;
  const double warming_s = cold_loss != 0 ? p[P::tyre_warm_up_s] : set.thermal_s;
  const double wind = car.terms[vehicle::Term::wind] * p[P::environment_wind_mps];
  const double wind_x = set.wind_x + wind * std::cos(p[P::environment_wind_heading_rad]), wind_y = set.wind_y + wind * std::sin(p[P::environment_wind_heading_rad]);
  int gear_now = 1;
  vehicle::Car<double> shell;  // only for choose_gear
  bool shell_made = false;
  const bool wheels_turn = has(kWheelFront) && !s.wheels_in_mps;

  for (std::size_t i = 0; i < s.n; ++i) {
    // Where relations hold: decided by the log alone.
    const double speed0 = s.x[kVx][i];
    const bool placed = std::isfinite(s.u_m[i]) && speed0 > 6.0;
    if (!placed) {
      last_alpha = {kNaN, kNaN};
      continue;
    }
    const double vx = x[kVx][i], vy = has(kVy) ? x[kVy][i] : 0.0;
    const double dvx = dx[kVx][i], dvy = has(kVy) ? dx[kVy][i] : 0.0;
    const double r = has(kYawRate) ? x[kYawRate][i] : dx[kYaw][i];
    const double dr = has(kYawRate) ? dx[kYawRate][i] : kNaN;
    const double px = dx[kX][i], py = dx[kY][i];
    // Road, with what it may be wrong by; a shift reads the road a little earlier or later.
    double grade = s.grade[i], bank = s.bank[i], vertical = s.curvature_v[i];
    if (set.shift_u != 0 && i > 0 && i + 1 < s.n) {
      const double per = set.shift_u / (speed0 * 2 * kStep);
      const auto move = [&](const std::vector<double>& v) { return std::isfinite(v[i + 1] - v[i - 1]) ? per * (v[i + 1] - v[i - 1]) : 0.0; };
      grade += move(s.grade);
      bank += move(s.bank);
      vertical += move(s.curvature_v);
    }
    grade += set.grade;
    bank += set.bank;
    vertical += set.vertical;

    // Sensors and kinematics.
    const double course = std::atan2(py, px);
    if (has(kYawRate)) {
      if (has(kYaw)) {
        out.r[Relation::kGyro][i] = r - dx[kYaw][i] * std::cos(std::atan(bank));
      } else if (i > 1 && i + 2 < s.n) {
        const double before = std::atan2(dx[kY][i - 2], dx[kX][i - 2]), after = std::atan2(dx[kY][i + 2], dx[kX][i + 2]);
        const double slip = has(kVy) ? (vx * dvy - vy * dvx) / (vx * vx) : 0.0;
        out.r[Relation::kGyro][i] = r - std::remainder(after - before, 2 * std::numbers::pi) / (4 * kStep) + slip;
      }
    }
    if (has(kYaw) && has(kVy)) out.r[Relation::kCourse][i] = std::remainder(course - x[kYaw][i] - std::atan2(vy, vx), 2 * std::numbers::pi);
    out.r[Relation::kSpeed][i] = std::hypot(px, py) - std::hypot(vx, vy);
    const double brake_log = has(kBrakeFront) ? s.x[kBrakeFront][i] : 0.0;
    const double delta = has(kSteer) ? steer[i] : 0.0;
    if (has(kWheelFront) && !(brake_log > 3e4)) {
      const double factor = wheels_turn ? radius[0] : set.wheel_radius[0];
      const double at_wheel = vx * std::cos(delta) + (vy + a * r) * std::sin(delta);
      out.r[Relation::kFrontWheels][i] = x[kWheelFront][i] * factor - at_wheel;
    }
    // Specific force of the body: what an accelerometer in the centre of mass would say.
    // Without a logged side slip, that of the path over the heading.
    const double across = has(kVy) || !has(kYaw) ? vy : vx * std::tan(std::clamp(std::remainder(course - x[kYaw][i], 2 * std::numbers::pi), -0.3, 0.3));
    const double sfx = dvx - r * across + g * grade;
    const double sfy = dvy + r * vx + g * bank;
    const double cy = std::cos(s.imu_yaw_rad + set.imu_yaw), sy = std::sin(s.imu_yaw_rad + set.imu_yaw);
    const double ahead = s.imu_ahead_m + set.imu_ahead;
    const double at_x = sfx - ahead * r * r, at_y = sfy + (std::isfinite(dr) ? ahead * dr : 0.0);
    if (has(kAx)) out.r[Relation::kAccelX][i] = x[kAx][i] - (cy * at_x + sy * at_y);
    if (has(kAy) && has(kVy)) out.r[Relation::kAccelY][i] = x[kAy][i] - (cy * at_y - sy * at_x);
    // The file's heights were read along the tangent, which the path leaves sideways; and what leans feels
    // a part of the turn.
    const double plus_g = vertical * vx * vx + s.bank[i] * r * vx + bank * r * vx;
    if (has(kAz)) out.r[Relation::kAccelZ][i] = x[kAz][i] - (g + plus_g);

    // Forces.
    const double mass = mass0 + (has(kFuel) ? x[kFuel][i] : 0.0) - set.burn * kStep * static_cast<double>(i);
    const double heading = has(kYaw) ? x[kYaw][i] : course;
    const double air_x = vx - (wind_x * std::cos(heading) + wind_y * std::sin(heading));
    const double air_y = vy - (-wind_x * std::sin(heading) + wind_y * std::cos(heading));
    const double air = std::hypot(air_x, air_y);
    const laws::AirForces<double> straight = laws::air_forces(p, air, air * air);
    std::array<double, 2> down{straight.front_n, straight.rear_n};
    double drag = straight.drag_nspm * air;
    if (const double amount = car.terms[vehicle::Term::aero_ride_height]; amount > 0 && !car.files.drag_factor.empty()) {
      std::array<double, 2> ride{};
      for (std::size_t k = 0; k < 2; ++k)
        ride[k] = p.axle(k, P::front_ride_height_m) -
                  0.5 * down[k] * (1 / std::max(1e4, p.axle(k, P::front_spring_npm)) + 1 / car.files.tyre[k].vertical_stiffness_npm);
      drag *= laws::map_factor(amount, car.files.drag_factor, ride[0], ride[1]);
      down[0] *= laws::map_factor(amount, car.files.front_lift_factor, ride[0], ride[1]);
      down[1] *= laws::map_factor(amount, car.files.rear_lift_factor, ride[0], ride[1]);
    }
    const double ride_loss = 1.0 - set.ride * laws::dynamic_pressure(p[P::aero_density_kgpm3], air) / 1000.0;
    down[0] *= ride_loss;
    down[1] *= ride_loss;
    down[0] *= car.terms[vehicle::Term::aero_downforce] + set.down;
    down[1] *= car.terms[vehicle::Term::aero_downforce] + set.down;
    drag *= car.terms[vehicle::Term::aero_drag] + set.drag;
    const double transfer_x = mass * sfx * h / wheelbase;
    std::array<double, 2> axle{mass * (g + plus_g) * b / wheelbase + down[0] - transfer_x,
                               mass * (g + plus_g) * a / wheelbase + down[1] + transfer_x};
    if (has(kLoadFront)) out.r[Relation::kLoadsFront][i] = (x[kLoadFront][i] - axle[0]) / mass0;
    if (has(kLoadRear)) out.r[Relation::kLoadsRear][i] = (x[kLoadRear][i] - axle[1]) / mass0;

    // Along the car: torques, not slips, so that no tyre curve enters.
    int gear = has(kGear) ? static_cast<int>(x[kGear][i]) : 0;
    bool shifting = false;
    if (has(kGear)) {
      for (std::size_t k = i > 5 ? i - 5 : 0; k < std::min(s.n, i + 4); ++k) shifting = shifting || x[kGear][k] != gear;
      shifting = shifting || gear < 1 || gear > 6;
    } else if (has(kEngine)) {
      // The gear whose ratio joins engine and wheels; between two of them the clutch is open.
      const double wheel = has(kWheelRear) ? s.x[kWheelRear][i] / (s.wheels_in_mps ? radius[1] : 1.0) : speed0 / radius[1];
      const double ratio = s.x[kEngine][i] / std::max(1.0, wheel) / p[P::gearbox_final];
      double nearest = 1e300;
      for (int k = 1; k <= 6; ++k) {
        const double stated = p[static_cast<P>(static_cast<std::size_t>(P::gearbox_ratio_1) + static_cast<std::size_t>(k) - 1)];
        const double off = stated > 0 ? std::abs(std::log(ratio / stated)) : 1e300;
        if (off < nearest) nearest = off, gear = k;
      }
      shifting = !(nearest < 0.05);
    } else {
      if (!shell_made) {
        shell.files = &car.files;
        shell.parameters = car.parameters;
        shell.terms = car.terms;
        shell.static_radius_m = {radius[0], radius[1]};
        shell_made = true;
      }
      gear_now = vehicle::choose_gear(shell, speed0, gear_now);
      gear = gear_now;
    }
    // What spins takes its part of the torque; how fast it speeds up is measured where it can be,
    // because slip has to build up before a force does.
    const auto spin = [&](Channel c, double rolling_m) {
      const double rate = has(c) ? (s.wheels_in_mps ? dx[c][i] / rolling_m : dx[c][i]) : dvx / rolling_m;
      return std::isfinite(rate) ? rate : dvx / rolling_m;
    };
    const double spin_front = spin(kWheelFront, radius[0]), spin_rear = spin(kWheelRear, radius[1]);
    double drive = 0.0, inertia = 2 * p.axle(0, P::front_wheel_inertia_kgm2) * spin_front / radius[0] +
                                  2 * p.axle(1, P::front_wheel_inertia_kgm2) * spin_rear / radius[1];
    const double thr = has(kThrottle) ? std::clamp(throttle[i], 0.0, 1.0) : kNaN;
    double torque = 0.0;
    if (!shifting && std::isfinite(thr)) {
      const double ratio = p[static_cast<P>(static_cast<std::size_t>(P::gearbox_ratio_1) + static_cast<std::size_t>(gear) - 1)] * p[P::gearbox_final];
      const double engine = has(kEngine) ? x[kEngine][i] : ratio * vx / radius[1];
      const double opening = std::clamp(thr * (s.commanded[kThrottle] ? p[P::throttle_gain] : 1.0), 0.0, 1.0);
      const auto map_nm = [&](double throttle_share) { return laws::map_torque(p[P::engine_torque], car.files.engine_torque_nm, engine, throttle_share); };
      torque = map_nm(opening);
      const double w = engine / p[P::engine_limit_radps];
      const double full = map_nm(1.0);
      torque += full * (set.engine_shape[0] * 4 * opening * (1 - opening) + opening * (set.engine_shape[1] * (w - 0.7) * 4 + set.engine_shape[2] * ((w - 0.7) * (w - 0.7) * 16 - 0.5)) +
                        set.engine_shape[3] * (1 - opening) * 0.3);
      if (!s.commanded[kThrottle]) torque += full * (p[P::throttle_gain] / car.parameters[P::throttle_gain] - 1.0) * opening * (1 - opening) * 2;
      torque = laws::limited_torque(torque, laws::fuelled_share(p[P::engine_limit_radps], engine));
      const double stated = car.terms[vehicle::Term::turbo_lag];
      if (set.turbo != 0 || stated != 0) {
        laws::BoostParameters<double> turbo = laws::boost_parameters(p);
        if (stated == 0) turbo.rise_s = set.turbo_rise_s;
        torque = laws::boosted_torque(torque, stated * p[P::turbo_share] + set.turbo, opening - boost);
        boost = laws::boost_after(turbo, boost, engine, opening, kStep);
      }
      drive = torque * ratio / radius[1] * laws::gear_efficiency(p[P::gearbox_efficiency], torque);
      inertia += p[P::engine_inertia_kgm2] * ratio * ratio * spin_rear / radius[1];
    }
    std::array<double, 2> brake{};
    // Fade that is found comes on top of what is stated, by the same law.
    const double fade_amount = car.terms[vehicle::Term::brake_fade], stated_1pmj = fade_amount != 0 ? p[P::brake_fade_1pmj] : 0.0;
    const double fade_s = stated_1pmj != 0 ? p[P::brake_fade_s] : set.fade_s;
    const double acts = stated_1pmj != 0 ? fade_amount : 1.0;
    const double bite = laws::pad_bite(acts, stated_1pmj + fade_1pmj(set.fade) / acts, pad_heat_j);
    if (has(kBrakeFront)) {
      // A measured pressure needs no gain to reach the pads; a change of it stands for their friction.
      const double brake_gain = p[P::brake_gain] / (s.commanded[kBrakeFront] ? 1.0 : car.parameters[P::brake_gain]);
      const auto force = [&](std::size_t k, double pa) {
        return 2 * laws::brake_torque(p.axle(k, P::front_brake_friction) * brake_gain * bite, positive(pa), p.axle(k, P::front_brake_area_m2), p.axle(k, P::front_brake_radius_m)) /
               radius[k];
      };
      if (std::isfinite(brake_front[i])) brake[0] = force(0, brake_front[i]);
      if (std::isfinite(brake_rear[i])) brake[1] = force(1, brake_rear[i]);
      pad_heat_j += kStep * laws::pad_heat_rate((brake[0] + brake[1]) * vx, pad_heat_j, fade_s);
    }
    std::array<double, 2> fx_axle{-brake[0], drive - brake[1]};

    // Across the car: slip angles, tyre curves of the stated car.
    std::array<double, 2> fy{};
    bool slips = has(kVy) && has(kSteer) && std::isfinite(delta);
    double side_drag = 0.0;
    if (slips) {
      std::array<double, 2> alpha{std::tan(std::atan2(vy + a * r, vx) - delta), std::tan(std::atan2(vy - b * r, vx))};
      // Lateral forces per mass do not depend on the mass but for the curvature of the tyre over load,
      // which no stated tyre has right: it must not pass for a mass.
      const double heavier = p[P::chassis_mass_kg] / car.parameters[P::chassis_mass_kg];
      const double missing = laws::warm_up_missing(cold, warmth);
      for (std::size_t k = 0; k < 2; ++k) {
        const vehicle::TyreCoefficients& tyre = car.files.tyre[k];
        const double share = k == 0 ? roll_share_front : 1 - roll_share_front;
        const double transfer_y = mass * sfy * h * share / track[k];
        const double raw = alpha[k];
        vehicle::TyreFactors<double> f;
        f.grip_x = f.grip_y = p.axle(k, P::front_tyre_grip) * s.grip[i] * (1 + set.friction) * (1 - missing);
        f.stiffness_x = p.axle(k, P::front_tyre_slip_stiffness);
        f.stiffness_y = p.axle(k, P::front_tyre_cornering_stiffness) * laws::warm_up_stiffness(missing);
        f.load_sensitivity = car.terms[vehicle::Term::tyre_load_sensitivity] + set.load_sensitivity;
        f.camber = car.terms[vehicle::Term::tyre_camber] + set.camber;
        f.combined_slip = std::max(0.0, car.terms[vehicle::Term::tyre_combined_slip] + set.combined);
        double slip = raw;
        const double relaxes = car.terms[vehicle::Term::tyre_relaxation] + set.relaxation;
        if (relaxes != 0 && std::isfinite(last_alpha[k])) {
          const auto origin = vehicle::tyre_stiffness(tyre, axle[k] / 2, p.axle(k, P::front_tyre_pressure_pa), f);
          const double sigma = vehicle::relaxation_lengths(tyre, axle[k] / 2, origin.slip_n, origin.cornering_npr).lateral_m;
          slip -= relaxes * sigma / vx * (raw - last_alpha[k]) / kStep;
        }
        last_alpha[k] = raw;
        double peak = 0.0;
        for (const double side : {1.0, -1.0}) {  // left, right
          const double fz = std::max(50.0, (axle[k] / 2 - side * transfer_y) / heavier);
          vehicle::TyreInput<double> in;
          in.fz_n = fz;
          in.vx_mps = vx;
          in.pressure_pa = p.axle(k, P::front_tyre_pressure_pa);
          const double camber = p.axle(k, P::front_camber_rad) + p.axle(k, P::front_camber_gain_radpm) * (-side * transfer_y) / roll_spring[k];
          in.gamma_rad = -side * camber;
          const auto origin = vehicle::tyre_stiffness(tyre, fz, in.pressure_pa, f);
          in.kappa = std::clamp(0.5 * fx_axle[k] / heavier / std::max(1.0, origin.slip_n), -0.15, 0.15);
          vehicle::TyreOptions options;
          options.alpha = car.files.alpha;
          options.mirrored = (side > 0) != tyre.left_side;
          options.moments = false;
          const auto at_slip = [&] {
            in.tan_alpha = slip / (1 + set.rolling_slip * in.kappa);
            return vehicle::tyre_forces(tyre, in, f, options);
          };
          auto force = at_slip();
          // The force along is known, not the slip: slip stiffness alone has too little of it near the limit.
          const double wanted = 0.5 * fx_axle[k] / heavier;
          for (int round = 0; round < 4 && std::abs(wanted) > 0.02 * fz && wanted * force.fx_n > 0; ++round) {
            in.kappa = std::clamp(in.kappa * std::min(2.0, wanted / force.fx_n), -0.15, 0.15);
            force = at_slip();
            if (std::abs(force.fx_n - wanted) < 0.01 * std::abs(wanted)) break;
          }
          fy[k] += heavier * force.fy_n;
          peak += heavier * force.mu_y * fz;
        }
        // What no stated curve has right: its shape between slope at the origin and peak, which are parameters of
        // their own (a bend, and one to either side of its middle, 2.6 making it as high), and what it does over load.
        const double use = std::clamp(fy[k] / std::max(1.0, peak), -1.0, 1.0);
        const double load = axle[k] / (2 * load0[k]) - 1.0;
        const double used = std::abs(use), bend = 4 * used * (1 - used);
        fy[k] *= 1.0 + set.curve[k] * bend + set.curve2[k] * 2.6 * bend * (1 - 2 * used) + set.load_curve[k] * load;
        fy[k] += set.drop[k] * mass0 * (k == 0 ? b : a) / wheelbase;
      }
      side_drag = fy[0] * std::sin(delta);
      if (cold != 0 && std::isfinite(sfy)) warmth += kStep * laws::warm_up_rate(warmth, warming_s, sfy);
    }
    const double rolling = set.rolling * (car.files.tyre[0].qsy1 * axle[0] + car.files.tyre[1].qsy1 * axle[1]) * car.terms[vehicle::Term::rolling_resistance];
    if (has(kThrottle) && !shifting) {
      const double force = fx_axle[0] * std::cos(delta) + fx_axle[1] - side_drag - drag * air_x / std::max(1.0, air) - rolling - inertia;
      out.r[Relation::kForceX][i] = sfx - force / mass;
    }
    // Slip of the driven wheels: from the force that the motion shows and the stated car, so that
    // what is wrong about slips never moves the engine or the drag.
    double slip = 0.0, inner_use = 0.0;
    if (has(kWheelRear)) {
      const vehicle::Parameters<double>& q = car.parameters;
      const double air_stated = laws::air_forces(q, speed0, speed0 * speed0).drag_nspm * speed0;
      const double pull = q[P::chassis_mass_kg] * (s.dx[kVx][i] - (has(kVy) && has(kYawRate) ? s.x[kVy][i] * s.x[kYawRate][i] : 0.0) + g * s.grade[i]);
      const double stiffness = 2 * vehicle::tyre_stiffness(car.files.tyre[1], q[P::chassis_mass_kg] * g * a / wheelbase / 2, q.axle(1, P::front_tyre_pressure_pa)).slip_n;
      const double lateral = speed0 * r / 15.0;
      // Use of grip of the driven wheel inside: near its limit a slip says nothing about a force.
      const double lean = q[P::chassis_mass_kg] * speed0 * (has(kYawRate) ? s.x[kYawRate][i] : s.dx[kYaw][i]);
      const double pressed = laws::air_forces(q, speed0, speed0 * speed0).rear_n * car.terms[vehicle::Term::aero_downforce];
      const double load = q[P::chassis_mass_kg] * (g * a + s.dx[kVx][i] * h) / wheelbase + pressed;
      const double inside = 0.5 * load - std::abs(lean) * h * (1 - roll_share_front) / track[1];
      inner_use = std::hypot(0.5 * (pull + air_stated) / std::max(50.0, inside), lean * a / wheelbase / std::max(50.0, load)) /
                  (car.files.tyre[1].pdx1 * q.axle(1, P::front_tyre_grip));
      if (std::isfinite(pull)) slip = (set.slip + set.slip_turning * lateral * lateral) * (pull + air_stated) / std::max(1e3, stiffness);
    }
    if (has(kWheelRear) && has(kThrottle) && !shifting && !(brake_log > 3e4)) {
      const double factor = wheels_turn ? radius[1] : set.wheel_radius[1];
      out.r[Relation::kRearWheels][i] = x[kWheelRear][i] * factor - vx * (1 + slip);
    }
    if (slips) {
      const double side_air = -laws::side_force(p, car.terms[vehicle::Term::aero_drag], air, air_y);
      const double total = fy[0] * std::cos(delta) + fx_axle[0] * std::sin(delta) + fy[1] - side_air;
      out.r[Relation::kForceY][i] = sfy - total / mass;
      if (std::isfinite(dr)) {
        const double moment = a * (fy[0] * std::cos(delta) + fx_axle[0] * std::sin(delta)) - b * fy[1] + side_air * p[P::aero_side_behind_cog_m];
        // The tyres' moment is the uncertain side: divided by the stated inertia and by the mass alone, so that
        // no inertia and no mass can make its error small.
        const double heavier = mass0 / car.parameters[P::chassis_mass_kg];
        out.r[Relation::kMomentZ][i] = (dr * p[P::chassis_yaw_inertia_kgm2] - moment) / (heavier * car.parameters[P::chassis_yaw_inertia_kgm2]);
      }
    }
    if (has(kWheelRearDifference)) {
      const double factor = s.wheels_in_mps ? 1.0 : radius[1];
      const double locked = car.terms[vehicle::Term::locked_differential] + set.lock;
      // Equal torques at unequal loads slip unequally, with an open differential too.
      const double stiffness = vehicle::tyre_stiffness(car.files.tyre[1], axle[1] / 2, p.axle(1, P::front_tyre_pressure_pa)).slip_n *
                               p.axle(1, P::front_tyre_slip_stiffness) * 2;
      const double driven = set.slip_across * fx_axle[1] / std::max(1e3, stiffness);
      const double moved = std::clamp(mass * sfy * h * (1 - roll_share_front) / track[1] / (axle[1] / 2), -0.8, 0.8);
      const double unequal = vx * driven * (1 / (1 - moved) - 1 / (1 + moved)) * (1 - locked);
      if (!shifting && has(kThrottle) && !(inner_use > 0.8)) out.r[Relation::kDifferential][i] = x[kWheelRearDifference][i] * factor + track[1] * r * (1 - locked) - unequal;
    }
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
