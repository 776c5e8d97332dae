#include "vehicle/laws/turbocharger.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "test_car.h"
#include "vehicle/poles.h"
#include "vehicle/work.h"

namespace turbocharger_test {

using namespace vehicle;  // NOLINT: a test of this library
using laws::kAirHeat;
using laws::kExhaustHeat;
using laws::kGas;
using P = Parameter;

constexpr double kPerRpm = std::numbers::pi / 30.0;

CarFiles turbo_files() {
  CarFiles files = test_car_files();
  files.turbo = Turbo::kFull;
  return files;
}

laws::TurboRates<double> rates(const Car<double>& car, const laws::TurboState<double>& s,
                               double engine_radps, double throttle) {
  const auto& t = car.terms;
  return laws::turbocharged<double>(
      laws::turbo_parameters(car.parameters),
      {t[Term::compressor_map], t[Term::wastegate], t[Term::overrun_valve], t[Term::intercooler],
       t[Term::turbine_map]},
      s, engine_radps, throttle, 1.0, dynamics::turbo_maps(*car.files));
}

// The isentropic nozzle of St. Venant and Wantzel for air.
TEST(Turbocharger, FlowsThroughANozzleLikeAnIsentropicOne) {
  const double gamma = 1.4, area = 1e-3, up = 2e5, kelvin = 300;
  const double critical = std::pow(2 / (gamma + 1), gamma / (gamma - 1));
  for (double ratio = 0.05; ratio < 0.975; ratio += 0.02) {
    const double r = std::max(ratio, critical);
    const double psi = std::sqrt(2 * gamma / (gamma - 1) *
                                 (std::pow(r, 2 / gamma) - std::pow(r, (gamma + 1) / gamma)));
    const double exact = area * up / std::sqrt(287 * kelvin) * psi;
    const auto flow = laws::nozzle<double>(area, up, ratio * up, kelvin, 400);
    EXPECT_NEAR(flow.kgps / exact, 1.0, 0.04) << ratio;
    EXPECT_EQ(laws::nozzle<double>(area, ratio * up, up, 400, kelvin).kgps, -flow.kgps);
  }
  EXPECT_EQ(laws::nozzle<double>(area, up, up, kelvin, kelvin).kgps, 0.0);
}

// Finite and continuous slopes on both sides of equal pressures; the stated ones are the Jet's.
TEST(Turbocharger, KnowsTheSlopesOfItsNozzle) {
  using Jet = ceres::Jet<double, 2>;
  double last = 0.0;
  for (double ratio = 0.3; ratio < 1.7; ratio += 0.001) {
    const Jet up(1.5e5, 0), down(1.5e5 * ratio, 1);
    const auto flow = laws::nozzle<Jet>(Jet(1e-3), up, down, Jet(310), Jet(310));
    EXPECT_NEAR(flow.per_before.a, flow.kgps.v[0], 1e-12);
    EXPECT_NEAR(flow.per_behind.a, flow.kgps.v[1], 1e-12);
    EXPECT_LT(std::abs(flow.per_behind.a), 1e-3 / std::sqrt(287 * 310) * 16);
    if (ratio > 0.3) {
      EXPECT_LT(std::abs(flow.kgps.a - last), 0.001 * 1.5e5 * 16e-3 / 298);
    }
    last = flow.kgps.a;
  }
}

TEST(Turbocharger, CompressesByHeadAndFlowOfItsWheel) {
  const CarFiles files = turbo_files();
  const Car<double> car = make_car(files, default_parameters(), default_amplitudes());
  const auto p = laws::turbo_parameters(car.parameters);
  const double shaft = 14000, tip = 0.5 * 0.056 * shaft, rho = 1.2;
  EXPECT_NEAR(p.air_pa, rho * 287 * 295, 1e-6);
  const double area = std::numbers::pi / 4 * 0.056 * 0.056;
  const auto at = [&](double pressure) {
    return laws::compressor<double>(p, shaft, pressure, {{}, {}, {}, {}}, 0.0);
  };
  // Without a rise of pressure: the flow coefficient alone.
  EXPECT_NEAR(at(p.air_pa).kgps, rho * area * tip * 0.30, 1e-9);
  EXPECT_NEAR(at(p.air_pa).isentropic_jpkg, 0.0, 1e-6);
  // Half of the largest head: 1 / sqrt 2 of that flow; all of it: none.
  const double head = 1.25 * 0.5 * tip * tip;
  const auto pressure = [&](double jpkg) {
    return p.air_pa * std::pow(1 + jpkg / (1004.5 * 295), 1004.5 / 287);
  };
  EXPECT_NEAR(at(pressure(head / 2)).kgps, rho * area * tip * 0.30 / std::sqrt(2), 1e-9);
  EXPECT_NEAR(at(pressure(head)).kgps, 0.0, 1e-9);
  EXPECT_LT(at(pressure(1.2 * head)).kgps, 0.0);
  // Best efficiency at phi = 0.16: head of 1 - (0.16 / 0.30)^2.
  EXPECT_NEAR(at(pressure(head * (1 - 0.16 * 0.16 / 0.09))).efficiency, 0.76, 1e-9);
  EXPECT_LT(at(pressure(0.5 * head)).efficiency, 0.76);
}

TEST(Turbocharger, TakesFlowAndEfficiencyFromItsMap) {
  CarFiles files = turbo_files();
  files.compressor_kgps = {{10000, 16000}, {1.0, 2.0, 3.0}, {0.2, 0.1, 0.0, 0.35, 0.25, 0.1}};
  files.compressor_efficiency = {{10000, 16000}, {1.0, 3.0}, {0.6, 0.7, 0.65, 0.75}};
  files.turbine_flow = {{100, 900}, {1.0, 4.0}, {2.0, 11.0, 1.0, 10.0}};
  files.turbine_efficiency = {{100, 900}, {1.0, 4.0}, {0.5, 0.6, 0.6, 0.7}};
  Amplitudes<double> terms = default_amplitudes();
  terms[Term::intercooler] = 0.0;
  const Car<double> car = make_car(files, default_parameters(), terms);
  const double air = laws::turbo_parameters(car.parameters).air_pa;
  const auto on = rates(car, {1.5e5, 2.0 * air, 2e5, 13000}, 400, 0.5);
  EXPECT_NEAR(on.compressor_kgps, 0.175, 1e-12);  // between 0.1 and 0.25
  const double heating = 295 * (std::pow(2.0, 287 / 1004.5) - 1) / 0.675;
  EXPECT_NEAR(on.charge_k, 295 + heating, 1e-9);
  EXPECT_NEAR(on.compressor_w, 0.175 * 1004.5 * heating, 1e-6);
  terms[Term::compressor_map] = 0.0;
  const Car<double> off = make_car(files, default_parameters(), terms);
  const CarFiles none = turbo_files();
  const Car<double> without = make_car(none, default_parameters(), terms);
  const auto a = rates(off, {1.5e5, 2.0 * air, 2e5, 13000}, 400, 0.5);
  const auto b = rates(without, {1.5e5, 2.0 * air, 2e5, 13000}, 400, 0.5);
  EXPECT_EQ(a.compressor_kgps, b.compressor_kgps);
  EXPECT_NE(a.compressor_kgps, on.compressor_kgps);
  terms[Term::intercooler] = 1.0;
  terms[Term::compressor_map] = 1.0;
  const Car<double> cooled = make_car(files, default_parameters(), terms);
  EXPECT_NEAR(rates(cooled, {1.5e5, 2.0 * air, 2e5, 13000}, 400, 0.5).charge_k,
              295 + 0.25 * heating, 1e-9);
}

// At the blade speed ratio of its best efficiency a turbine gives that share of the isentropic
// drop; at twice the ratio none. Its flow is choked far from equal pressures, none at them.
TEST(Turbocharger, ExpandsThroughTheTurbine) {
  const CarFiles files = turbo_files();
  Amplitudes<double> terms = default_amplitudes();
  terms[Term::wastegate] = 0.0;
  Parameters<double> p = default_parameters();
  p[P::intake_cooler] = 1.0;  // so that the gas is as hot whatever the shaft's speed
  const Car<double> car = make_car(files, p, terms);
  const double air = laws::turbo_parameters(car.parameters).air_pa;
  const auto r = rates(car, {1.8e5, 1.9e5, 2.2e5, 10000}, 500, 1.0);
  const double drop = 1150 * r.exhaust_k * (1 - std::pow(air / 2.2e5, 287.0 / 1150));
  const double best = 0.65 * std::sqrt(2 * drop) / 0.025;
  const auto at_best = rates(car, {1.8e5, 1.9e5, 2.2e5, best}, 500, 1.0);
  EXPECT_NEAR(at_best.turbine_w / (at_best.turbine_kgps * drop), 0.70, 1e-3);
  EXPECT_NEAR(rates(car, {1.8e5, 1.9e5, 2.2e5, 2 * best}, 500, 1.0).turbine_w, 0.0, 40.0);
  EXPECT_NEAR(
      at_best.turbine_kgps,
      3.0e-4 * 2.2e5 / std::sqrt(287 * r.exhaust_k) * std::sqrt(1 - std::pow(air / 2.2e5, 2)),
      1e-9);
  EXPECT_NEAR(rates(car, {1.8e5, 1.9e5, air, best}, 500, 1.0).turbine_kgps, 0.0, 1e-12);
}

// First law over the cylinders: fuel = work on the pistons + coolant + what the gas carries off.
TEST(Turbocharger, LosesNoHeatOfTheFuel) {
  const CarFiles files = turbo_files();
  const Car<double> car = make_car(files, default_parameters(), default_amplitudes());
  for (const double engine : {200.0, 450.0, 700.0}) {
    const auto r = rates(car, {1.7e5, 2.0e5, 2.1e5, 14000}, engine, 0.7);
    const double losses_nm = 0.002 / (4 * std::numbers::pi) * engine / (engine + 10) *
                             (80000 + 150 * engine + 2.1e5 - 1.7e5);
    const double work = (r.engine_nm + losses_nm) * engine;
    const double gas = (r.cylinder_kgps + r.fuel_kgps) * kExhaustHeat * (r.exhaust_k - r.charge_k);
    EXPECT_NEAR((work + 0.25 * r.fuel_kgps * 43e6 + gas) / (r.fuel_kgps * 43e6), 1.0, 1e-9);
    EXPECT_GT(r.exhaust_k, 1000);
    EXPECT_LT(r.exhaust_k, 1350);
    EXPECT_NEAR(r.shaft_nm * 14000, r.turbine_w - r.compressor_w - r.bearing_w, 1e-6);
  }
}

template <class T>
State<T> rate_of(const Car<T>& car, const State<double>& s, const Inputs<double>& in) {
  State<T> at, out;
  for (std::size_t i = 0; i < kStateSize; ++i) at[i] = T(s[i]);
  Inputs<T> lifted;
  lifted.throttle = T(in.throttle);
  lifted.gear = in.gear;
  Detail<T> detail;
  RoadCursors cursors;
  derivative(car, at, lifted, Road(), cursors, out, detail);
  settle_frictions(car, 0.001, out, detail);
  settle_air(0.001, out, detail);
  return out;
}

// Open, half open, closed throttle: derivatives after all that the air path knows, through the
// implicit step.
TEST(Turbocharger, DifferentiatesLikeCentralDifferences) {
  using Jet = ceres::Jet<double, 1>;
  CarFiles files = turbo_files();
  files.compressor_kgps = {{10000, 16000}, {1.0, 2.0, 3.0}, {0.2, 0.1, 0.0, 0.35, 0.25, 0.1}};
  files.compressor_efficiency = {{10000, 16000}, {1.0, 3.0}, {0.6, 0.7, 0.65, 0.75}};
  Parameters<double> p = default_parameters();
  Amplitudes<double> terms = default_amplitudes();
  for (const Term t : {Term::compressor_map, Term::wastegate, Term::overrun_valve,
                       Term::intercooler, Term::turbine_map})
    terms[t] = 0.6;
  std::mt19937 random(3);
  struct Point {
    double throttle, manifold, charge;
  };
  for (const Point at : {Point{1.0, 2.38e5, 2.4e5}, Point{0.5, 1.2e5, 2.35e5},
                         Point{0.0, 4e4, 0.9e5 + 4e4 + 5e3}, Point{0.0, 1.6e5, 2.1e5}}) {
    State<double> s = random_state(random);
    s[kManifold] = at.manifold;
    s[kCharge] = at.charge;
    Inputs<double> in;
    in.throttle = at.throttle;
    in.gear = 3;
    std::size_t moved = 0;
    for (std::size_t k = 0; k < kParameterCount + kTermCount; ++k) {
      const bool is_parameter = k < kParameterCount;
      const std::string_view name =
          is_parameter ? parameter_list()[k].name : term_list()[k - kParameterCount].name;
      const bool of_engine = name.starts_with("engine.") || name.starts_with("intake.") ||
                             name.starts_with("compressor") || name.starts_with("turb") ||
                             name == "wastegate" || name == "overrun_valve" ||
                             name == "intercooler" || name == "turbine_map" ||
                             name == "aero.density_kgpm3" || name == "environment.temperature_k" ||
                             name == "fuel.energy_jpkg";
      if (!of_engine || name == "turbo_lag") continue;
      Parameters<Jet> pj;
      Amplitudes<Jet> tj;
      for (std::size_t i = 0; i < kParameterCount; ++i) pj.value[i] = Jet(p.value[i]);
      for (std::size_t i = 0; i < kTermCount; ++i) tj.value[i] = Jet(terms.value[i]);
      (is_parameter ? pj.value[k] : tj.value[k - kParameterCount]).v[0] = 1.0;
      const State<Jet> jet = rate_of(make_car<Jet>(files, pj, tj), s, in);
      const double x = is_parameter ? p.value[k] : terms.value[k - kParameterCount];
      const auto shifted = [&](double by) {
        Parameters<double> pd = p;
        Amplitudes<double> td = terms;
        (is_parameter ? pd.value[k] : td.value[k - kParameterCount]) += by;
        return rate_of(make_car(files, pd, td), s, in);
      };
      const double h = 1e-4 * x;
      const auto a = shifted(h), b = shifted(-h), c = shifted(2 * h), d = shifted(-2 * h);
      for (const std::size_t i : {kEngine, kFuel, kManifold, kCharge, kExhaust, kTurbo}) {
        const double expected = (8 * (a[i] - b[i]) - (c[i] - d[i])) / (12 * h);
        if (expected != 0.0) ++moved;
        const double noise = 3e-15 * (std::abs(jet[i].a) + 1e6 * (i >= kManifold)) / h;
        EXPECT_NEAR(jet[i].v[0], expected,
                    1e-6 * std::abs(expected) + 1e-6 * std::abs(jet[i].a / x) + noise)
            << state_name(i) << " after " << name << " at throttle " << at.throttle;
      }
    }
    EXPECT_GT(moved, 60u);
  }
}

// The stated Jacobian of the pressures is that of their rates, where nothing but pressures moves
// the temperatures little: within 12 % of the larger entries.
TEST(Turbocharger, KnowsHowItsPressuresDriftBack) {
  const CarFiles files = turbo_files();
  const Car<double> car = make_car(files, default_parameters(), default_amplitudes());
  const laws::TurboState<double> s{1.5e5, 1.56e5, 1.7e5, 11000};
  const auto r = rates(car, s, 400, 0.8);
  const auto moved = [&](double laws::TurboState<double>::*which) {
    laws::TurboState<double> up = s, down = s;
    up.*which += 1;
    down.*which -= 1;
    return std::pair(rates(car, up, 400, 0.8), rates(car, down, 400, 0.8));
  };
  using S = laws::TurboState<double>;
  const auto [mu, md] = moved(&S::manifold_pa);
  const auto [cu, cd] = moved(&S::charge_pa);
  const auto [eu, ed] = moved(&S::exhaust_pa);
  const auto close = [](double got, double expected) {
    EXPECT_NEAR(got / expected, 1.0, 0.12) << got << ' ' << expected;
  };
  close(r.drift.manifold, (mu.manifold_paps - md.manifold_paps) / 2);
  close(r.drift.charge_manifold, (mu.charge_paps - md.charge_paps) / 2);
  close(r.drift.manifold_charge, (cu.manifold_paps - cd.manifold_paps) / 2);
  close(r.drift.charge, (cu.charge_paps - cd.charge_paps) / 2);
  close(r.drift.exhaust, (eu.exhaust_paps - ed.exhaust_paps) / 2);
}

/// The engine on a test bench that holds its speed: part throttle until all is steady, then wide
/// open, then closed.
struct Bench {
  std::vector<double> time_s, torque_nm, manifold_pa, charge_pa, compressor_kgps;
  double low_nm = 0, most_nm = 0, rise_s = 0;  ///< before, long after; time to 90 % of the rise
  double largest_swing = 0;  ///< of the manifold's pressure, relative, step to step
};

Bench bench(double rpm, const StepOptions& options, const Amplitudes<double>& terms,
            double close_s = 1e9, const Parameters<double>& p = default_parameters(),
            const CarFiles& files = turbo_files()) {
  Amplitudes<double> own = terms;
  own[Term::throttle_actuator] = 0.0;
  const Car<double> car = make_car(files, p, own);
  const Road road;
  Simulation<double> sim = start(car, road, {});
  Controls<double> controls;
  controls.gear_command = 0;
  Detail<double> detail;
  Bench out;
  const double settle_s = 6.0, open_s = 8.0;
  const auto steps = [&](double s) { return std::lround(s / options.step_s); };
  std::array<double, 3> before{};
  for (long i = 0; i < steps(settle_s + open_s); ++i) {
    const double t = static_cast<double>(i) * options.step_s - settle_s;
    controls.throttle_command = t < -options.step_s / 2 ? 0.16 : (t < close_s ? 1.0 : 0.0);
    sim.state[kEngine] = rpm * kPerRpm;
    for (const std::size_t k : {kX, kY, kVx, kVy}) sim.state[k] = 0.0;
    const StepResult result = step(car, sim, controls, road, options, detail);
    EXPECT_TRUE(result.ok()) << describe(result, t, 0, 0);
    if (!result.ok()) return out;
    out.time_s.push_back(t);
    out.torque_nm.push_back(detail.engine_nm);
    out.manifold_pa.push_back(sim.state[kManifold]);
    out.charge_pa.push_back(sim.state[kCharge]);
    out.compressor_kgps.push_back(detail.turbo.compressor_kgps);
    before = {before[1], before[2], sim.state[kManifold]};
    if (i > 2) {
      const double one = before[1] - before[0], two = before[2] - before[1];
      if (one * two < 0)
        out.largest_swing = std::max(out.largest_swing,
                                     std::min(std::abs(one), std::abs(two)) / sim.state[kManifold]);
    }
  }
  const auto at = static_cast<std::size_t>(steps(settle_s));
  out.low_nm = out.torque_nm[at - 1];
  out.most_nm = out.torque_nm.back();
  for (std::size_t i = at; i < out.torque_nm.size(); ++i)
    if (out.torque_nm[i] > 0.9 * out.most_nm) {
      out.rise_s = out.time_s[i];
      break;
    }
  return out;
}

// Published: the makers of a turbocharged 3.0 l road car say that it needs three seconds at 1800
// rpm to its greatest torque (Car and Driver, June 2016, which measured a 2.3 l one from 1500 rpm
// at 0.8 s behind an engine without turbocharger). The faster the engine the shorter, there and
// here.
TEST(Turbocharger, TipsInAsFastAsMeasuredEngines) {
  double last_s = 3.0;
  for (const double rpm : {1800.0, 2500.0, 3500.0}) {
    const Bench b = bench(rpm, {}, default_amplitudes());
    RecordProperty("rise_s_" + std::to_string(std::lround(rpm)), std::to_string(b.rise_s));
    EXPECT_GT(b.rise_s, rpm < 2000 ? 0.8 : 0.2) << rpm;
    EXPECT_LT(b.rise_s, 0.9 * last_s) << rpm;
    last_s = b.rise_s;
    // The boost makes most of it: without, an engine of this size has less than 190 N m.
    EXPECT_GT(b.most_nm, 350) << rpm;
    EXPECT_LT(b.low_nm, 100) << rpm;
  }
}

// The open throttle evens out pressures faster than the step: no swings, the same rise, at any
// step, by both integrators, up to the limiter and with the smallest volumes allowed.
TEST(Turbocharger, IsStableAtAnyStepAndConverges) {
  for (const double rpm : {1800.0, 6500.0}) {
    const Bench fine = bench(rpm, {0.0002, Integrator::kExplicitEuler}, default_amplitudes());
    for (const double step_s : {0.0005, 0.001})
      for (const Integrator integrator : {Integrator::kExplicitEuler, Integrator::kSemiImplicit}) {
        const Bench b = bench(rpm, {step_s, integrator}, default_amplitudes());
        EXPECT_NEAR(b.rise_s / fine.rise_s, 1.0, 0.002 + 20 * (step_s - 0.0002))
            << rpm << ' ' << step_s;
        EXPECT_NEAR(b.most_nm / fine.most_nm, 1.0, 1e-4) << rpm << ' ' << step_s;
        EXPECT_LT(b.largest_swing, 1e-4) << rpm << ' ' << step_s;
      }
  }
  Parameters<double> p = default_parameters();
  p[P::intake_manifold_m3] = 2e-3;
  p[P::intake_charge_m3] = p[P::turbine_exhaust_m3] = 5e-4;
  EXPECT_LT(bench(3500, {}, default_amplitudes(), 1e9, p).largest_swing, 1e-3);
}

// Any engine within a tenth and ten times of every number, so far as the bounds allow, part of them
// at once: pressures stay numbers and swing by no more than 3 % in a step of 1 ms.
TEST(Turbocharger, IsStableWhateverItsParameters) {
  std::mt19937 random(11);
  const int trials = std::getenv("KERBSTONE_HEAVY") != nullptr ? 40 : 12;
  for (int trial = 0; trial < trials; ++trial) {
    Parameters<double> p = default_parameters();
    std::string changed;
    for (std::size_t k = 0; k < kParameterCount; ++k) {
      const ParameterInfo& info = parameter_list()[k];
      if (!info.text.starts_with("full turbo") || random() % 4 != 0) continue;
      const double low = std::max(info.low, 0.1 * info.value);
      const double high = std::min(info.high, 10 * info.value);
      p.value[k] = low * std::pow(high / low, static_cast<double>(random() % 10001) / 1e4);
      changed += std::string(info.name) + "=" + std::to_string(p.value[k]) + " ";
    }
    const double rpm = 1000.0 + 6.0 * static_cast<double>(random() % 1001);
    EXPECT_LT(bench(rpm, {}, default_amplitudes(), 5.0, p).largest_swing, 0.03) << changed;
  }
}

TEST(Turbocharger, HoldsItsBoostByTheWastegate) {
  Amplitudes<double> terms = default_amplitudes();
  const Bench with = bench(4000, {}, terms);
  terms[Term::wastegate] = 0.0;
  const Bench without = bench(4000, {}, terms);
  const double air = 1.2 * 287 * 295;
  EXPECT_GT(with.charge_pa.back(), air + 1.2e5);        // begins to open
  EXPECT_LT(with.charge_pa.back(), air + 1.2e5 + 4e4);  // open
  EXPECT_GT(without.charge_pa.back(), air + 2.2e5);
}

TEST(Turbocharger, LetsTheChargeOutByTheOverrunValve) {
  Amplitudes<double> terms = default_amplitudes();
  const auto after_closing = [&] {
    const Bench b = bench(4000, {}, terms, 5.0);
    double most_pa = 0, least_kgps = 1;
    for (std::size_t i = 0; i < b.time_s.size(); ++i)
      if (b.time_s[i] > 5.05) {
        most_pa = std::max(most_pa, b.charge_pa[i]);
        least_kgps = std::min(least_kgps, b.compressor_kgps[i]);
      }
    return std::pair(most_pa, least_kgps);
  };
  const auto with = after_closing();
  terms[Term::overrun_valve] = 0.0;
  const auto without = after_closing();
  EXPECT_LT(without.second, 0.003);  // hardly any flow against full boost: surge
  EXPECT_GT(with.second, without.second + 0.005);
  EXPECT_LT(with.first, without.first - 2e4);
}

// A map of the turbine by hand: reduced flow 9 kg sqrt(K)/(s MPa) and efficiency 0.65 everywhere.
TEST(Turbocharger, TurbineFollowsItsMap) {
  CarFiles files = turbo_files();
  files.turbine_flow = {{0, 1000}, {1.0, 4.0}, {9.0, 9.0, 9.0, 9.0}};
  files.turbine_efficiency = {{0, 1000}, {1.0, 4.0}, {0.65, 0.65, 0.65, 0.65}};
  Amplitudes<double> terms = default_amplitudes();
  const Car<double> car = make_car(files, default_parameters(), terms);
  const laws::TurboState<double> s{1.7e5, 2.0e5, 2.1e5, 14000};
  const auto r = rates(car, s, 450, 0.7);
  const double air_pa = 1.2 * 287 * 295;
  EXPECT_NEAR(r.turbine_kgps, 9e-6 * 2.1e5 / std::sqrt(r.exhaust_k), 1e-12);
  const double isentropic = 1150 * r.exhaust_k * (1 - std::pow(air_pa / 2.1e5, 287.0 / 1150.0));
  EXPECT_NEAR(r.turbine_w, 0.65 * r.turbine_kgps * isentropic, 1e-6 * r.turbine_w);
  EXPECT_NEAR(r.shaft_nm * 14000, r.turbine_w - r.compressor_w - r.bearing_w, 1e-6);
  terms[Term::turbine_map] = 0.0;
  const auto off = rates(make_car(files, default_parameters(), terms), s, 450, 0.7);
  const CarFiles plain = turbo_files();
  const auto closed = rates(make_car(plain, default_parameters(), terms), s, 450, 0.7);
  EXPECT_EQ(off.turbine_w, closed.turbine_w);
  EXPECT_EQ(off.exhaust_paps, closed.exhaust_paps);
  EXPECT_GT(std::abs(r.turbine_w - closed.turbine_w), 1.0);
  terms[Term::turbine_map] = 0.25;  // a quarter of the way, flow first
  const auto part = rates(make_car(files, default_parameters(), terms), s, 450, 0.7);
  EXPECT_NEAR(part.turbine_kgps,
              closed.turbine_kgps + 0.25 * (r.turbine_kgps - closed.turbine_kgps), 1e-12);
}

// A map that flows and turns as a maker's does: the engine settles, without swings, at two steps.
TEST(Turbocharger, RunsOnATurbineMap) {
  const auto at_least = [](double step_s) {
    CarFiles files = turbo_files();
    files.turbine_flow = {{100, 300, 600},
                          {1.0, 1.3, 1.8, 2.5, 4.0},
                          {0, 8, 11, 12, 12.2, 0, 7, 10.5, 11.8, 12.1, 0, 6, 10, 11.5, 12}};
    files.turbine_efficiency = {{100, 300, 600},
                                {1.0, 1.5, 2.5, 4.0},
                                {0.5, 0.45, 0.35, 0.3, 0.6, 0.66, 0.6, 0.5, 0.4, 0.6, 0.68, 0.62}};
    return bench(3500, {step_s, Integrator::kSemiImplicit}, default_amplitudes(), 1e9,
                 default_parameters(), files);
  };
  const Bench coarse = at_least(0.001), fine = at_least(0.0002);
  EXPECT_GT(fine.most_nm, 250.0);
  EXPECT_NEAR(coarse.most_nm / fine.most_nm, 1.0, 1e-3);
  EXPECT_NEAR(coarse.rise_s / fine.rise_s, 1.0, 0.03);
  EXPECT_LT(coarse.largest_swing, 1e-4);
}

// The surge line is the reader's: below it, in no flow, is surge; without a line nothing is said.
TEST(Turbocharger, TellsSurgeByItsLine) {
  const Map1 line{{1.0, 2.0, 3.0}, {0.01, 0.03, 0.06}};
  EXPECT_TRUE(laws::surges(line, 0.0449, 2.5));
  EXPECT_FALSE(laws::surges(line, 0.0451, 2.5));
  EXPECT_TRUE(laws::surges(line, -0.01, 1.0));
  EXPECT_FALSE(laws::surges({}, -0.01, 2.5));
}

// What changes the energy of car and shaft are the powers, and step by step their work.
TEST(Turbocharger, ClosesTheEnergyAccount) {
  using Jet = ceres::Jet<double, 1>;
  CarFiles files = turbo_files();
  files.turbine_efficiency = {{100, 900}, {1.0, 4.0}, {0.5, 0.6, 0.6, 0.7}};
  const Car<double> car = make_car(files, default_parameters(), default_amplitudes());
  std::mt19937 random(9);
  const State<double> s = random_state(random);
  const Inputs<double> in = random_inputs(random);
  State<double> rate;
  Detail<double> detail;
  RoadCursors cursors;
  derivative(car, s, in, Road(), cursors, rate, detail);
  Parameters<Jet> pj;
  Amplitudes<Jet> tj;
  for (std::size_t i = 0; i < kParameterCount; ++i) pj.value[i] = Jet(car.parameters.value[i]);
  for (std::size_t i = 0; i < kTermCount; ++i) tj.value[i] = Jet(car.terms.value[i]);
  State<Jet> along;
  for (std::size_t i = 0; i < kStateSize; ++i) {
    along[i] = Jet(s[i]);
    along[i].v[0] = rate[i];
  }
  EXPECT_NE(detail.power.turbo, 0.0);
  EXPECT_NEAR(energy(make_car<Jet>(files, pj, tj), along).v[0], detail.power.sum(), 1e-2);

  // Twenty seconds of pedal on and off through the gears.
  const Road road;
  StartOptions begin;
  begin.speed_mps = 25;
  begin.gear = 2;
  Simulation<double> sim = start(car, road, begin);
  const double first = energy(car, sim.state);
  double work = 0, traffic = 0;
  Controls<double> controls;
  for (int i = 0; i < 20000; ++i) {
    controls.throttle_command = i % 3000 < 2000 ? 1.0 : 0.0;
    controls.gear_command = sim.state[kVx] < 35 ? 2 : 3;
    const State<double> before = sim.state;
    ASSERT_TRUE(step(car, sim, controls, road, {}, detail).ok());
    const Powers<double> done = work_of_step(car, before, sim.state, detail, {});
    work += done.sum();
    traffic += std::abs(done.engine) + std::abs(done.turbo);
  }
  EXPECT_NEAR(energy(car, sim.state) - first, work, 2e-4 * traffic);
  EXPECT_LT(sim.state[kFuel], begin.fuel_kg - 0.05);
}

TEST(Turbocharger, HasPolesInsideTheUnitCircle) {
  const CarFiles files = turbo_files();
  const Car<double> car = make_car(files, default_parameters(), default_amplitudes());
  for (const double speed : {5.5, 30.0, 60.0})
    for (const auto& radius : linearise(car, speed, {0.001, 0.0012}).radii) {
      EXPECT_LT(radius.semi_implicit, 1.0) << speed;
      EXPECT_LT(radius.explicit_euler, 1.0) << speed;
    }
}

}  // namespace turbocharger_test
