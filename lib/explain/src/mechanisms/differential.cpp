// Driven wheels that are coupled otherwise than stated.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "car_changes.h"
#include "effect.h"
#include "listing.h"
#include "vehicle/laws/aero.h"
#include "vehicle/magic_formula.h"

namespace explain::differential {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;

constexpr const char* kId = kCoupledWheels;
constexpr const char* kExperiment = "slow tight circles, power on and off";
constexpr const char* kOtherwise = "the driven wheels are coupled otherwise than stated";

/// The coupling of the driven wheels that takes away the share `wanted` of the speed difference
/// that turning asks for, with the slip stiffnesses K of the wheels as loaded: c v / R^2 (1 /
/// K_left + 1 / K_right) = share / (1 - share).
double coupling_nms(const Underway& now, double wanted) {
  const auto& p = now.parameters;
  const double share = std::clamp(wanted, -0.9, 0.98);
  double yielding = 0.0;
  for (const std::size_t wheel : {2, 3})
    yielding +=
        1 / std::max(1e3, p[P::rear_tyre_slip_stiffness] *
                              vehicle::tyre_stiffness(now.car.files->tyre[1],
                                                      std::max(50.0, now.last.wheel[wheel].fz_n),
                                                      p[P::rear_tyre_pressure_pa])
                                  .slip_n);
  const double radius = now.last.wheel[2].rolling_radius_m;
  return share / (1 - share) * radius * radius / (std::max(6.0, now.vx_mps) * yielding);
}

/// Amount: share of the speed difference that is taken away.
constexpr Effect kCouple{
    .at_begin = [](vehicle::Car<double>& car,
                   const Acting&) { car.terms[Term::locked_differential] = 1.0; },
    .on_the_way =
        [](Underway& now, const Acting& a) {
          now.parameters[P::differential_lock_nms] = coupling_nms(now, a.amount[0]);
        }};

void list(const Listing& l) {
  if (!has(l, kWheelRearDifference))
    return untestable(l, kId, "the rear wheels' speeds are not both logged");
  if (l.car.terms[Term::locked_differential] != 0.0)
    candidate(l, kId, {"locked_differential", "1", -0.2, 0.08},
              {kOtherwise, "torque = amount lock_nms (omega_l - omega_r)", kExperiment},
              [](Setting& s, double v) { s.act(kMoreOf<Term::locked_differential>, v); });
  else if (l.car.terms[Term::limited_slip] != 0.0)
    candidate(l, kId, {"limited_slip", "1", -0.2, 0.08},
              {kOtherwise, "torque = amount (preload + ramp torque)", kExperiment},
              [](Setting& s, double v) { s.act(kMoreOf<Term::limited_slip>, v); });
  else
    candidate(
        l, kId, {"locked share", "1", 0.2, 0.08, true},
        {"the driven wheels are coupled", "omega_l - omega_r = -(1 - k) track r / R", kExperiment},
        [](Setting& s, double v) { s.act(kCouple, v); });
}

/// v / R^2 (1 / K_left + 1 / K_right), and its weight.
struct Yielding {
  double per, weight;
};

/// At every step of the logs: the wheels as loaded and slipping sideways.
std::vector<Yielding> yieldings(const CarChanges& out) {
  const vehicle::TyreCoefficients& tyre = out.car.files.tyre[1];
  const auto& p = out.car.parameters;
  const auto roll = [&](P spring, P bar, P track) {
    return (p[spring] + 2 * p[bar]) * p[track] * p[track];
  };
  const double rear_roll = roll(P::rear_spring_npm, P::rear_anti_roll_npm, P::rear_track_m);
  const double lean =
      p[P::chassis_mass_kg] * p[P::chassis_cog_height_m] / p[P::rear_track_m] * rear_roll /
      (rear_roll + roll(P::front_spring_npm, P::front_anti_roll_npm, P::front_track_m));
  const double radius = tyre.unloaded_radius_m * tyre.qre0;
  const double weight = p[P::chassis_mass_kg] * p[P::environment_gravity_mps2] *
                        p[P::chassis_cog_behind_front_m] / p[P::chassis_wheelbase_m];
  const double behind = p[P::chassis_wheelbase_m] - p[P::chassis_cog_behind_front_m];
  std::vector<Yielding> points;
  at_speeds(out.logs, [&](double speed, double rate, double across) {
    const double down = vehicle::laws::air_forces(p, speed, speed * speed).rear_n *
                        out.car.terms[Term::aero_downforce];
    const double load = 0.5 * (weight + down);
    const double moved = std::min(0.9 * load, lean * speed * std::abs(rate));
    const auto stiffness = [&](double n) {
      vehicle::TyreInput<double> in;
      in.fz_n = n;
      in.tan_alpha = (across - behind * rate) / speed;
      in.vx_mps = speed;
      in.pressure_pa = p[P::rear_tyre_pressure_pa];
      vehicle::TyreFactors<double> factors;
      factors.grip_x = factors.grip_y = p[P::rear_tyre_grip];
      factors.stiffness_x = p[P::rear_tyre_slip_stiffness];
      factors.stiffness_y = p[P::rear_tyre_cornering_stiffness];
      const vehicle::TyreOptions options{.alpha = out.car.files.alpha, .moments = false};
      in.kappa = 0.005;
      const double driven = vehicle::tyre_forces(tyre, in, factors, options).fx_n;
      in.kappa = -0.005;
      return std::max(1e3, (driven - vehicle::tyre_forces(tyre, in, factors, options).fx_n) / 0.01);
    };
    points.push_back(
        {speed / (radius * radius) * (1 / stiffness(load + moved) + 1 / stiffness(load - moved)),
         rate * rate});
  });
  return points;
}

/// A coupling whose torque grows with the speed difference of the driven wheels, strong enough to
/// take away the share that was found of what turning asks for, at the speeds and yaw rates of the
/// logs; see coupling_nms().
void write_coupling(CarChanges& out, const Finding& f) {
  const double wanted = std::clamp(f.parameters[0].value, 0.02, 0.98);
  const std::vector<Yielding> points = yieldings(out);
  const auto share = [&](double coupling) {
    double sum = 0, all = 1e-300;
    for (const auto& [per, w] : points) sum += w * coupling * per / (1 + coupling * per), all += w;
    return sum / all;
  };
  double low = 0, high = 1e5;
  for (int k = 0; k < 60; ++k)
    (share(0.5 * (low + high)) < wanted ? low : high) = 0.5 * (low + high);
  out.set(Term::locked_differential, wanted);
  out.set(Term::limited_slip, 0);
  out.set(P::differential_lock_nms, low / wanted);
}

void write(CarChanges& out, const Finding& f) {
  const auto term = vehicle::find_term(f.parameters[0].name);
  if (!term) return write_coupling(out, f);
  out.set(*term, std::clamp(out.car.terms[*term] + f.parameters[0].value, 0.0, 1.0));
}

}  // namespace

std::vector<Mechanism> mechanisms() {
  return {{.id = kId, .list = list, .most = 1.3, .write_car = write}};
}

}  // namespace explain::differential
