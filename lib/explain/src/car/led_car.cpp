#include "led_car.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

#include "effect.h"
#include "engine_and_brakes.h"
#include "not_known.h"
#include "vehicle/step.h"

namespace explain {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;
constexpr double kSettle_s = 0.6;  ///< before a stretch, held to its beginning

/// The engine's map with the shape that the setting gives it.
vehicle::Map2 engine_of(const vehicle::Vehicle& car, const Setting& set, bool throttle_measured) {
  std::array<double, 4> shape = set.engine_shape;
  // A measured throttle needs no gain: one that is off is a map that is off between the ends.
  if (throttle_measured)
    shape[0] += 0.5 * (set.p[P::throttle_gain] / car.parameters[P::throttle_gain] - 1.0);
  return shaped_engine_map(car.files.engine_torque_nm, shape, set.p[P::engine_limit_radps]);
}

vehicle::CarFiles files_with(const Signals& s, const vehicle::Vehicle& car, const Setting& set) {
  vehicle::CarFiles files = car.files;
  // With the command beside it the gain lies between the two.
  files.engine_torque_nm =
      engine_of(car, set, !s.commanded[kThrottle] && !s.present[kThrottleCommand]);
  for (std::size_t axle = 0; axle < 2; ++axle) {
    vehicle::TyreCoefficients& tyre = files.tyre[axle];
    tyre.qsy1 *= set.rolling;
    tyre.deflection_share *= set.radius_by_load;
    // A logger's own radius is no property of the tyre.
    if (!s.wheels_in_mps) tyre.unloaded_radius_m *= set.wheel_radius[axle];
  }
  return files;
}

/// The car with the setting's amounts; measured controls go past their actuators.
vehicle::Car<double> car_with(const Signals& s, const vehicle::Vehicle& stated,
                              const vehicle::CarFiles& files, const Setting& set,
                              double reserve_kg) {
  vehicle::Parameters<double> p = set.p;
  p[P::chassis_mass_kg] -= reserve_kg;
  if (reserve_kg != 0 && !s.present[kFuel]) {  // out of the centre of mass
    p[P::fuel_tank_behind_front_m] = p[P::chassis_cog_behind_front_m];
    p[P::fuel_tank_height_m] = p[P::chassis_cog_height_m];
  }
  const auto list = vehicle::parameter_list();
  for (std::size_t i = 0; i < vehicle::kParameterCount; ++i)
    p.value[i] = std::clamp(p.value[i], list[i].low, list[i].high);
  // What is tried of another car's file may burn more fuel than the car weighs.
  const double wheels_kg = 2 * (p[P::front_unsprung_mass_kg] + p[P::rear_unsprung_mass_kg]);
  p[P::chassis_mass_kg] = std::max(p[P::chassis_mass_kg], 1.5 * wheels_kg);
  vehicle::Car<double> car = vehicle::make_car(files, p, stated.terms);
  auto& q = car.parameters;
  auto& terms = car.terms;
  const auto past = [&](Term term) { terms[term] = 0.0; };
  if (!s.commanded[kSteer])
    for (const Term t : {Term::steering_actuator, Term::steering_friction, Term::steering_backlash})
      past(t);
  if (!s.commanded[kThrottle])
    for (const Term t : {Term::throttle_actuator, Term::throttle_friction}) past(t);
  if (!s.commanded[kBrakeFront]) past(Term::brake_actuator);
  q[P::rear_tyre_slip_stiffness] *= set.slip;
  terms[Term::wheel_reaction] += set.reaction;
  for (const Acting& a : set.effects)
    if (a.effect->at_begin != nullptr && a.amount != std::array<double, 2>{})
      a.effect->at_begin(car, a);
  // The log says how much fuel there is.
  past(Term::fuel_burn);
  return car;
}

double between(const std::vector<double>& x, std::size_t i, double share) {
  return x[i] + share * (x[i + 1] - x[i]);
}

/// What one substep tells, in the order of Led.
using Told = std::array<double, 10>;

/// Forces that no stated tyre has right: shape of its curve between the slope at the origin and the
/// peak, what it does over load, a constant side force. Added to what the car told.
void add_curves(const Setting& set, const vehicle::Car<double>& car,
                const vehicle::Detail<double>& detail, double steer_rad, Told& told) {
  const auto& p = car.parameters;
  const double mass = p[P::chassis_mass_kg], wheelbase = p[P::chassis_wheelbase_m];
  const double a = p[P::chassis_cog_behind_front_m];
  for (std::size_t k = 0; k < 2; ++k) {
    if (set.curve[k] == 0 && set.curve2[k] == 0 && set.load_curve[k] == 0 && set.drop[k] == 0)
      continue;
    const auto &left = detail.wheel[2 * k], &right = detail.wheel[2 * k + 1];
    const double fy = left.fy_n + right.fy_n, fz = left.fz_n + right.fz_n;
    const vehicle::TyreCoefficients& tyre = car.files->tyre[k];
    const double peak = std::abs(tyre.pdy1) * p.axle(k, P::front_tyre_grip) * fz;
    const double use = std::min(1.0, std::abs(fy) / std::max(1.0, peak));
    const double bend = 4 * use * (1 - use), load = fz / (2 * car.static_load_n[k]) - 1.0;
    // A bend, and one to either side of its middle, 2.6 making it as high.
    double more = fy * (set.curve[k] * bend + set.curve2[k] * 2.6 * bend * (1 - 2 * use) +
                        set.load_curve[k] * load);
    more += set.drop[k] * mass * (k == 0 ? wheelbase - a : a) / wheelbase;
    if (k == 0) told[0] -= more * std::sin(steer_rad) / mass;
    if (k == 0) more *= std::cos(steer_rad);
    told[1] += more / mass;
    told[2] += more * (k == 0 ? a : a - wheelbase) / p[P::chassis_yaw_inertia_kgm2];
  }
}

/// The car on its way.
class Drive {
 public:
  Drive(const Signals& s, const vehicle::Vehicle& stated, const Setting& set, const Lead& by)
      : s_(s),
        set_(set),
        by_(by),
        files_(files_with(s, stated, set)),
        car_(car_with(s, stated, files_, set, by.reserve_kg)),
        stated_gain_(s.commanded[kBrakeFront] ? 1.0 : stated.parameters[P::brake_gain]),
        grip_{car_.parameters[P::front_tyre_grip], car_.parameters[P::rear_tyre_grip]},
        lift_{car_.parameters[P::front_lift_area_m2], car_.parameters[P::rear_lift_area_m2]} {
    options_.step_s = Signals::kStep_s / set.substeps;
  }

  void begin(std::size_t i) {
    vehicle::StartOptions begin;
    begin.speed_mps = by_.vx_mps[i];
    begin.gear = by_.gear[i];
    begin.fuel_kg = by_.fuel_kg[i] + by_.reserve_kg;
    const vehicle::Simulation<double> last = sim_;
    sim_ = vehicle::start(car_, road_, begin);
    if (driven_) {  // what outlasts a gap
      for (std::size_t k = 0; k < vehicle::kStateSize; ++k)
        if (vehicle::kStates[k].kept) sim_.state[k] = last.state[k];
    }
    driven_ = true;
    for (int k = 0; k < static_cast<int>(kSettle_s / options_.step_s); ++k) {
      Told told;
      if (!move(i, 0.0, told)) return;
    }
  }

  /// One substep between rows i and i + 1; false: the car is lost.
  bool move(std::size_t i, double share, Told& told) {
    auto& s = sim_.state;
    auto& p = car_.parameters;
    const std::size_t near = share < 0.5 ? i : i + 1;
    if (by_.gear[near] != sim_.discrete.gear) change_gear(by_.gear[near]);
    const double vx = between(by_.vx_mps, i, share), r = between(by_.yaw_radps, i, share);
    s[vehicle::kVx] = vx;
    s[vehicle::kYawRate] = r;
    s[vehicle::kYaw] = between(by_.yaw_rad, i, share);
    if (by_.vy_known)
      s[vehicle::kVy] =
          between(by_.vy_mps, i, share) + s[vehicle::kVz] * std::sin(s[vehicle::kRoll]);
    s[vehicle::kFuel] = between(by_.fuel_kg, i, share) + by_.reserve_kg;
    p[P::environment_gravity_mps2] = between(by_.gravity_mps2, i, share);
    Underway now{p, car_, detail_, vx, s_.grip[near]};
    for (const Acting& a : set_.effects)
      if (a.effect->on_the_way != nullptr && a.amount[0] != 0) a.effect->on_the_way(now, a);
    p[P::front_tyre_grip] = grip_[0] * now.grip;
    p[P::rear_tyre_grip] = grip_[1] * now.grip;
    p[P::front_lift_area_m2] = lift_[0] * now.lift;
    p[P::rear_lift_area_m2] = lift_[1] * now.lift;
    vehicle::Controls<double> c;
    c.gear_command = by_.gear[near];
    c.steer_command_rad =
        between(by_.steer, i, share) * (s_.commanded[kSteer] ? 1.0 : p[P::steering_ratio]);
    if (!by_.throttle.empty())
      c.throttle_command =
          between(by_.throttle, i, share) / (s_.commanded[kThrottle] ? 1.0 : p[P::throttle_gain]);
    if (!by_.brake_front_pa.empty()) {
      c.brake_command_pa = {brake(by_.brake_front_pa, by_.brake_front_apart_pa, 0.5, i, share),
                            brake(by_.brake_front_pa, by_.brake_front_apart_pa, -0.5, i, share),
                            brake(by_.brake_rear_pa, by_.brake_rear_apart_pa, 0.5, i, share),
                            brake(by_.brake_rear_pa, by_.brake_rear_apart_pa, -0.5, i, share)};
    }
    const vehicle::State<double> before = s;
    if (!vehicle::step(car_, sim_, c, road_, options_, detail_).ok()) return false;
    const auto rate = [&](std::size_t k) { return (s[k] - before[k]) / options_.step_s; };
    // Force per mass along the axes of the body, turned into the road's plane.
    const double vy = before[vehicle::kVy], vz = before[vehicle::kVz];
    const double wx = before[vehicle::kRollRate], wy = before[vehicle::kPitchRate];
    const double fx = rate(vehicle::kVx) + wy * vz - r * vy;
    const double fy = rate(vehicle::kVy) + r * vx - wx * vz;
    const double fz = rate(vehicle::kVz) + wx * vy - wy * vx;
    const double sr = std::sin(before[vehicle::kRoll]), cr = std::cos(before[vehicle::kRoll]);
    const double sp = std::sin(before[vehicle::kPitch]), cp = std::cos(before[vehicle::kPitch]);
    const auto& w = detail_.wheel;
    told = {fx * cp + (fy * sr + fz * cr) * sp,
            fy * cr - fz * sr,
            rate(vehicle::kYawRate),
            w[0].fz_n + w[1].fz_n,
            w[2].fz_n + w[3].fz_n,
            0.5 * (before[vehicle::kSpin + 2] + before[vehicle::kSpin + 3]),
            0.5 * (w[2].rolling_radius_m + w[3].rolling_radius_m),
            before[vehicle::kSpin + 2] - before[vehicle::kSpin + 3],
            before[vehicle::kRoll],
            before[vehicle::kPitch]};
    add_curves(set_, car_, detail_, detail_.inputs.steer_rad, told);
    return true;
  }

 private:
  /// `side`: 0.5 left, -0.5 right.
  double brake(const std::vector<double>& mean_pa, const std::vector<double>& apart_pa, double side,
               std::size_t i, double share) const {
    // The logger's noise around 0 would brake: only one side of it counts.
    constexpr double kLeast_pa = 3e4;
    const double x =
        between(mean_pa, i, share) + (apart_pa.empty() ? 0.0 : side * between(apart_pa, i, share));
    return x > kLeast_pa ? x / stated_gain_ : 0.0;
  }

  /// The log says when: no time for it, and the engine turns as the wheels do.
  void change_gear(int gear) {
    auto& s = sim_.state;
    sim_.discrete.gear = sim_.discrete.gear_wanted = gear;
    sim_.discrete.shift_left_s = 0.0;
    const double ratio = vehicle::overall_ratio(car_.parameters, gear);
    s[vehicle::kEngine] = std::max(car_.parameters[P::engine_idle_radps],
                                   ratio * 0.5 * (s[vehicle::kSpin + 2] + s[vehicle::kSpin + 3]));
  }

  const Signals& s_;
  const Setting& set_;
  const Lead& by_;
  vehicle::CarFiles files_;
  vehicle::Car<double> car_;
  double stated_gain_;
  std::array<double, 2> grip_, lift_;
  vehicle::Road road_;
  vehicle::StepOptions options_;
  vehicle::Simulation<double> sim_{};
  vehicle::Detail<double> detail_{};
  bool driven_ = false;
};

}  // namespace

bool same_drive(const KnownDrive& known, const Setting& setting, const Lead& by) {
  // What sensors, road and delays do to the drive stands in what leads it.
  const auto of_the_car = [](Setting s) {
    const Setting none;
    s.sensor = none.sensor;
    s.throttle_s = s.brake_s = s.steer_s = s.steer_lag_s = s.burn = 0.0;
    s.bank = s.grade = s.vertical = s.shift_u = s.imu_yaw = s.imu_ahead = 0.0;
    s.vy_ahead = s.place_ahead = s.derived_ax = s.level = s.filter_lead_s = 0.0;
    s.pressure_by_command = none.pressure_by_command;
    s.along = {};
    return s;
  };
  const auto same = [](const auto& a, const auto& b) {
    using Value = typename std::decay_t<decltype(a)>::value_type;
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Value& x, const Value& y) {
      return x == y || (x != x && y != y);  // both NaN
    });
  };
  const Lead& k = known.by;
  return k.vy_known == by.vy_known && k.reserve_kg == by.reserve_kg && same(k.vx_mps, by.vx_mps) &&
         (!k.vy_known || same(k.vy_mps, by.vy_mps)) && same(k.yaw_radps, by.yaw_radps) &&
         same(k.yaw_rad, by.yaw_rad) && same(k.steer, by.steer) && same(k.throttle, by.throttle) &&
         same(k.brake_front_pa, by.brake_front_pa) && same(k.brake_rear_pa, by.brake_rear_pa) &&
         same(k.brake_front_apart_pa, by.brake_front_apart_pa) &&
         same(k.brake_rear_apart_pa, by.brake_rear_apart_pa) && same(k.gear, by.gear) &&
         same(k.gravity_mps2, by.gravity_mps2) && same(k.fuel_kg, by.fuel_kg) &&
         of_the_car(known.setting) == of_the_car(setting);
}

Led lead(const Signals& s, const vehicle::Vehicle& stated, const Setting& set, const Lead& by) {
  Led out;
  const std::array<std::vector<double>*, 10> told_of{
      &out.force_x_mps2, &out.force_y_mps2, &out.yaw_radps2,     &out.load_front_n,
      &out.load_rear_n,  &out.rear_radps,   &out.rear_rolling_m, &out.rear_difference_radps,
      &out.roll_rad,     &out.pitch_rad};
  for (auto* v : told_of) v->assign(s.n, kNaN);
  const auto led = [&](std::size_t i) {
    return i < s.n &&
           std::isfinite(by.vx_mps[i] + by.yaw_radps[i] + by.yaw_rad[i] + by.gravity_mps2[i] +
                         by.steer[i] + by.fuel_kg[i]) &&
           (!by.vy_known || std::isfinite(by.vy_mps[i])) &&
           (by.throttle.empty() || std::isfinite(by.throttle[i])) &&
           (by.brake_front_pa.empty() ||
            (std::isfinite(by.brake_front_pa[i]) && std::isfinite(by.brake_rear_pa[i])));
  };
  Drive drive(s, stated, set, by);
  Told sum{}, told{};
  int count = 0;
  bool going = false;
  for (std::size_t i = 0; i + 1 < s.n; ++i) {
    if (!led(i) || !led(i + 1)) {
      going = false;
      continue;
    }
    if (!going) {
      drive.begin(i);
      sum = {};
      count = 0;
    }
    going = true;
    for (int k = 0; k < set.substeps && going; ++k) {
      if (k == set.substeps / 2) {
        if (count == set.substeps)
          for (std::size_t q = 0; q < told.size(); ++q) (*told_of[q])[i] = sum[q] / count;
        sum = {};
        count = 0;
      }
      going = drive.move(i, (k + 0.5) / set.substeps, told);
      for (std::size_t q = 0; q < told.size(); ++q) sum[q] += told[q];
      ++count;
    }
  }
  return out;
}

}  // namespace explain
