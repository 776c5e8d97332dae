#include "vehicle/straight_run.h"

#include <algorithm>
#include <cmath>

#include "vehicle/driver.h"
#include "vehicle/laws/driveline.h"
#include "vehicle/laws/engine.h"
#include "vehicle/magic_formula.h"
#include "vehicle/steady_engine.h"
#include "vehicle/step.h"

namespace vehicle {
namespace {

constexpr double kHundred_mps = 100.0 / 3.6, kLongest_s = 240.0;

/// Beyond where the clutch holds.
double launch_radps(const Car<double>& car) {
  return 1.3 * car.parameters[Parameter::clutch_full_radps];
}

/// What the driven wheels can pull in a gear, as torques of the engine.
struct Pull {
  double clutch_nm = 0.0;  ///< that the wheels take
  double engine_nm = 0.0;  ///< and what it takes to speed the engine up with them
};

Pull most_pull(const Car<double>& car, const Detail<double>& detail, int gear) {
  using P = Parameter;
  constexpr double kOfPeak = 0.97, kMostSlip = 0.12;
  const Parameters<double>& p = car.parameters;
  double pull_n = 0.0, slip = 0.0;
  for (const std::size_t i : {2u, 3u}) {
    const double load_n = std::max(detail.wheel[i].fz_n, 0.5 * car.static_load_n[1]);
    const TyreInput<double> tyre{load_n, 0, 0, 0, 30, p[P::rear_tyre_pressure_pa]};
    pull_n += load_n * p[P::rear_tyre_grip] *
              tyre_forces(car.files->tyre[1], tyre, {}, {.moments = false}).mu_x;
    slip = std::max(slip, detail.wheel[i].kappa);
  }
  // Wheels that spin all the same get less.
  pull_n *= kOfPeak * std::clamp(2.0 - slip / kMostSlip, 0.3, 1.0);
  const double ratio_1pm = overall_ratio(p, gear) / car.static_radius_m[1];
  const double clutch_nm = pull_n / (ratio_1pm * p[P::gearbox_efficiency]);
  return {clutch_nm,
          clutch_nm + p[P::engine_inertia_kgm2] * ratio_1pm * pull_n / p[P::chassis_mass_kg]};
}

/// All that the wheels can take: by the throttle, and by the clutch what the engine has stored.
Controls<double> launch(const Car<double>& car, const Map2& engine, const State<double>& state,
                        const Detail<double>& detail, int gear) {
  const Parameters<double>& p = car.parameters;
  const Pull most = most_pull(car, detail, gear);
  const double full_nm = laws::map_torque(p[Parameter::engine_torque], engine, state[kEngine], 1.0);
  // What boost is missing he makes up for by the throttle.
  const double lag = car.files->turbo == Turbo::kFull
                         ? 0.0
                         : car.terms[Term::turbo_lag] * p[Parameter::turbo_share] *
                               std::clamp(1.0 - detail.boost, 0.0, 1.0);
  const double wanted_nm = most.engine_nm / (1.0 - lag);
  Controls<double> out;
  out.gear_command = gear;
  out.throttle_command =
      full_nm <= wanted_nm
          ? 1.0
          : throttle_for(engine, state[kEngine], wanted_nm / p[Parameter::engine_torque]);
  // In the first gear the clutch slips so that the engine keeps the speed that he revved it to.
  const bool keeps = gear == 1 && state[kEngine] < launch_radps(car);
  const double hold_nm =
      keeps ? std::min(most.clutch_nm, std::max(0.0, detail.engine_nm)) : most.clutch_nm;
  const double capacity_nm =
      laws::clutch_capacity(p, value_of(car.terms[Term::centrifugal_clutch]), state[kEngine]);
  out.clutch_command = std::clamp(1.0 - hold_nm / std::max(1.0, capacity_nm), 0.0, 1.0);
  return out;
}

}  // namespace

StraightRun run_straight(const Car<double>& car) {
  const Road road;
  StartOptions begin;
  begin.fuel_kg = 0.0;
  Simulation<double> sim = start(car, road, begin);
  Detail<double> detail{};
  // He revs the engine up first.
  sim.state[kEngine] = launch_radps(car);
  const StepOptions options;
  const Map2 steady = steady_engine(car);
  const Map2& engine = steady.empty() ? car.files->engine_torque_nm : steady;
  StraightRun out;
  int gear = 1;
  double second_ago_mps = 0.0;
  const auto per_second = static_cast<std::size_t>(std::lround(1.0 / options.step_s));
  for (std::size_t i = 1; sim.time_s < kLongest_s; ++i) {
    const double vx = sim.state[kVx];
    out.top_mps = std::max(out.top_mps, vx);
    if (out.to_100_kmh_s == 0.0 && vx >= kHundred_mps) out.to_100_kmh_s = sim.time_s;
    if (i % per_second == 0) {
      if (vx > 1.0 && vx - second_ago_mps < 0.01) break;
      second_ago_mps = vx;
    }
    gear = choose_gear(car, vx, gear);
    const Controls<double> controls = launch(car, engine, sim.state, detail, gear);
    const StepResult result = step(car, sim, controls, road, options, detail);
    if (!result.ok()) {
      out.problem = describe(result, sim.time_s, sim.state[kX], sim.state[kY]);
      break;
    }
  }
  return out;
}

}  // namespace vehicle
