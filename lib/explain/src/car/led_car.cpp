#include "led_car.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "convoys.h"
#include "effect.h"
#include "not_known.h"
#include "vehicle/step_many.h"

namespace explain {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;
constexpr double kSettle_s = 0.6;  ///< before a stretch, held to its beginning

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

/// A car on its way.
class Drive {
 public:
  Drive(const Signals& s, const vehicle::Vehicle& stated, const vehicle::CarFiles& files,
        const Guided& guided)
      : s_(s),
        set_(*guided.setting),
        by_(*guided.by),
        car_(car_with(s, stated, files, set_, by_.reserve_kg)),
        stated_gain_(s.commanded[kBrakeFront] ? 1.0 : stated.parameters[P::brake_gain]),
        grip_{car_.parameters[P::front_tyre_grip], car_.parameters[P::rear_tyre_grip]},
        lift_{car_.parameters[P::front_lift_area_m2], car_.parameters[P::rear_lift_area_m2]} {}

  const vehicle::Car<double>& car() const { return car_; }

  bool leads(std::size_t i) const {
    return i < s_.n &&
           std::isfinite(by_.vx_mps[i] + by_.yaw_radps[i] + by_.yaw_rad[i] + by_.gravity_mps2[i] +
                         by_.steer[i] + by_.fuel_kg[i]) &&
           (!by_.vy_known || std::isfinite(by_.vy_mps[i])) &&
           (by_.throttle.empty() || std::isfinite(by_.throttle[i])) &&
           (by_.brake_front_pa.empty() ||
            (std::isfinite(by_.brake_front_pa[i]) && std::isfinite(by_.brake_rear_pa[i])));
  }

  void begin(std::size_t i, const vehicle::Road& road, vehicle::Simulation<double>& sim) {
    vehicle::StartOptions begin;
    begin.speed_mps = by_.vx_mps[i];
    begin.gear = by_.gear[i];
    begin.fuel_kg = by_.fuel_kg[i] + by_.reserve_kg;
    const vehicle::Simulation<double> last = sim;
    sim = vehicle::start(car_, road, begin);
    if (driven_) {  // what outlasts a gap
      for (std::size_t k = 0; k < vehicle::kStateSize; ++k)
        if (vehicle::kStates[k].kept) sim.state[k] = last.state[k];
    }
    driven_ = true;
  }

  /// What moves between steps of the same car.
  static constexpr std::array<P, 5> kMoving{P::environment_gravity_mps2, P::front_tyre_grip,
                                            P::rear_tyre_grip, P::front_lift_area_m2,
                                            P::rear_lift_area_m2};

  /// Leads the car to a place between rows i and i + 1; what it is asked there. `last`: of the
  /// substep before.
  vehicle::Controls<double> ask(std::size_t i, double share, vehicle::Simulation<double>& sim,
                                const vehicle::Detail<double>& last) {
    auto& s = sim.state;
    auto& p = car_.parameters;
    const std::size_t near = share < 0.5 ? i : i + 1;
    if (by_.gear[near] != sim.discrete.gear) change_gear(by_.gear[near], sim);
    const double vx = between(by_.vx_mps, i, share), r = between(by_.yaw_radps, i, share);
    s[vehicle::kVx] = vx;
    s[vehicle::kYawRate] = r;
    s[vehicle::kYaw] = between(by_.yaw_rad, i, share);
    if (by_.vy_known)
      s[vehicle::kVy] =
          between(by_.vy_mps, i, share) + s[vehicle::kVz] * std::sin(s[vehicle::kRoll]);
    s[vehicle::kFuel] = between(by_.fuel_kg, i, share) + by_.reserve_kg;
    p[P::environment_gravity_mps2] = between(by_.gravity_mps2, i, share);
    Underway now{p, car_, last, vx, s_.grip[near]};
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
    before_ = s;
    return c;
  }

  /// What the substep told that ask() began.
  Told tell(const vehicle::State<double>& s, const vehicle::Detail<double>& detail,
            double step_s) const {
    const vehicle::State<double>& before = before_;
    const auto rate = [&](std::size_t k) { return (s[k] - before[k]) / step_s; };
    // Force per mass along the axes of the body, turned into the road's plane.
    const double vy = before[vehicle::kVy], vz = before[vehicle::kVz];
    const double wx = before[vehicle::kRollRate], wy = before[vehicle::kPitchRate];
    const double r = before[vehicle::kYawRate];
    const double fx = rate(vehicle::kVx) + wy * vz - r * vy;
    const double fy = rate(vehicle::kVy) + r * before[vehicle::kVx] - wx * vz;
    const double fz = rate(vehicle::kVz) + wx * vy - wy * before[vehicle::kVx];
    const double sr = std::sin(before[vehicle::kRoll]), cr = std::cos(before[vehicle::kRoll]);
    const double sp = std::sin(before[vehicle::kPitch]), cp = std::cos(before[vehicle::kPitch]);
    const auto& w = detail.wheel;
    Told told{fx * cp + (fy * sr + fz * cr) * sp,
              fy * cr - fz * sr,
              rate(vehicle::kYawRate),
              w[0].fz_n + w[1].fz_n,
              w[2].fz_n + w[3].fz_n,
              0.5 * (before[vehicle::kSpin + 2] + before[vehicle::kSpin + 3]),
              0.5 * (w[2].rolling_radius_m + w[3].rolling_radius_m),
              before[vehicle::kSpin + 2] - before[vehicle::kSpin + 3],
              before[vehicle::kRoll],
              before[vehicle::kPitch]};
    add_curves(set_, car_, detail, detail.inputs.steer_rad, told);
    return told;
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
  void change_gear(int gear, vehicle::Simulation<double>& sim) const {
    auto& s = sim.state;
    sim.discrete.gear = sim.discrete.gear_wanted = gear;
    sim.discrete.shift_left_s = 0.0;
    const double ratio = vehicle::overall_ratio(car_.parameters, gear);
    s[vehicle::kEngine] = std::max(car_.parameters[P::engine_idle_radps],
                                   ratio * 0.5 * (s[vehicle::kSpin + 2] + s[vehicle::kSpin + 3]));
  }

  const Signals& s_;
  const Setting& set_;
  const Lead& by_;
  vehicle::Car<double> car_;
  double stated_gain_;
  std::array<double, 2> grip_, lift_;
  vehicle::State<double> before_{};  ///< the substep that is under way
  bool driven_ = false;
};

/// Cars with the same files on their way, all in the same substep.
class Convoy {
 public:
  Convoy(const Signals& s, const vehicle::Vehicle& stated, std::span<const Guided> cars)
      : files_(files_with(s, stated, *cars.front().setting)),
        substeps_(cars.front().setting->substeps),
        sims_(cars.size()),
        controls_(cars.size()),
        results_(cars.size(), kStands),
        details_(cars.size()),
        sums_(cars.size()),
        led_(cars.size()) {
    options_.step_s = Signals::kStep_s / substeps_;
    std::vector<const vehicle::Car<double>*> places;
    drives_.reserve(cars.size());
    for (const Guided& guided : cars)
      places.push_back(&drives_.emplace_back(s, stated, files_, guided).car());
    if (places.size() > 1) packs_.emplace(places, options_.step_s);
    for (Led& led : led_)
      for (const auto& of : kToldOf) (led.*of).assign(s.n, kNaN);
  }

  /// From row i to the next, who is led there.
  void go_on(std::size_t i) {
    std::vector<vehicle::StepResult> next = results_;
    bool any = false, begins = false;
    for (std::size_t k = 0; k < drives_.size(); ++k) {
      const bool led = drives_[k].leads(i) && drives_[k].leads(i + 1);
      next[k] = led ? vehicle::StepResult{} : kStands;
      any = any || led;
      if (results_[k].ok() || !led) {
        results_[k] = kStands;  // until the others have settled
        continue;
      }
      drives_[k].begin(i, road_, sims_[k]);
      sums_[k] = {};
      results_[k] = {};
      begins = true;
    }
    if (!any) return;
    for (int n = 0; begins && n < static_cast<int>(kSettle_s / options_.step_s); ++n) move(i, 0.0);
    results_ = std::move(next);
    for (int n = 0; n < substeps_; ++n) {
      if (n == substeps_ / 2) tell(i);
      move(i, (n + 0.5) / substeps_);
      for (std::size_t k = 0; k < drives_.size(); ++k) {
        if (!results_[k].ok()) continue;
        const Told told = drives_[k].tell(sims_[k].state, details_[k], options_.step_s);
        for (std::size_t q = 0; q < told.size(); ++q) sums_[k].of[q] += told[q];
        ++sums_[k].count;
      }
    }
  }
  std::vector<Led> led() && { return std::move(led_); }

 private:
  struct Sum {
    Told of{};
    int count = 0;
  };
  static constexpr vehicle::StepResult kStands{vehicle::StepResult::Problem::kNotFinite, 0};
  static constexpr std::array<std::vector<double> Led::*, std::tuple_size_v<Told>> kToldOf{
      &Led::force_x_mps2, &Led::force_y_mps2, &Led::yaw_radps2,     &Led::load_front_n,
      &Led::load_rear_n,  &Led::rear_radps,   &Led::rear_rolling_m, &Led::rear_difference_radps,
      &Led::roll_rad,     &Led::pitch_rad};

  /// One substep of all that go; who is lost stands.
  void move(std::size_t i, double share) {
    for (std::size_t k = 0; k < drives_.size(); ++k)
      if (results_[k].ok()) controls_[k] = drives_[k].ask(i, share, sims_[k], details_[k]);
    if (packs_) {
      packs_->take(Drive::kMoving);
      step_many(*packs_, sims_, controls_, road_, options_, results_, details_);
    } else if (results_[0].ok()) {
      results_[0] =
          vehicle::step(drives_[0].car(), sims_[0], controls_[0], road_, options_, details_[0]);
    }
  }

  /// Means over the step of time around row i, where all of it was driven.
  void tell(std::size_t i) {
    for (std::size_t k = 0; k < drives_.size(); ++k) {
      if (!results_[k].ok()) continue;
      if (sums_[k].count == substeps_)
        for (std::size_t q = 0; q < kToldOf.size(); ++q)
          (led_[k].*kToldOf[q])[i] = sums_[k].of[q] / sums_[k].count;
      sums_[k] = {};
    }
  }

  vehicle::CarFiles files_;
  vehicle::Road road_;
  vehicle::StepOptions options_;
  int substeps_;
  std::vector<Drive> drives_;
  std::vector<vehicle::Simulation<double>> sims_;
  std::vector<vehicle::Controls<double>> controls_;
  std::vector<vehicle::StepResult> results_;  ///< ok: under way
  std::vector<vehicle::Detail<double>> details_;
  std::vector<Sum> sums_;
  std::vector<Led> led_;
  std::optional<vehicle::CarPacks> packs_;
};

}  // namespace

std::vector<Led> lead(const Signals& s, const vehicle::Vehicle& stated,
                      std::span<const Guided> cars, const std::function<void()>& tick) {
  constexpr std::size_t kRowsPerTick = 200;
  Convoy convoy(s, stated, cars);
  for (std::size_t i = 0; i + 1 < s.n; ++i) {
    convoy.go_on(i);
    if (tick && i % kRowsPerTick == 0) tick();
  }
  return std::move(convoy).led();
}

Led lead(const Signals& s, const vehicle::Vehicle& stated, const Setting& set, const Lead& by) {
  const Guided one{&set, &by};
  return std::move(lead(s, stated, std::span(&one, 1)).front());
}

}  // namespace explain
