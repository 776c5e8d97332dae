#include "vehicle/laws/turn_slip.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "support/places.h"
#include "test_car.h"
#include "vehicle/magic_formula.h"
#include "vehicle/step_swing.h"

namespace turn_slip_test {

using namespace vehicle;  // NOLINT: a test of this library
using Point = TyreInput<double>;

Point point(double fz_n, double kappa, double alpha, double gamma, double turn_1pm, double vx_mps) {
  Point in{fz_n, kappa, std::tan(alpha), gamma, vx_mps, 0.0};
  in.turn_1pm = turn_1pm;
  return in;
}

// Numbers of the published equations, written down once more in another language for these points
// of a public sample file: every zeta, with load, both slips, inclination and turning.
TEST(TurnSlip, FollowsThePublishedEquations) {
  const std::string file = places::data() + "/tyre/sample_mf62.tir";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file;
  const TyreCoefficients tyre = read_tyre(file).coefficients;
  ASSERT_TRUE(has_turn_slip(tyre));
  static constexpr struct {
    double fz_n, kappa, alpha, gamma, turn_1pm, vx_mps, fx_n, fy_n, mz_nm;
  } kPoints[] = {
      {4000, 0, 0, 0, 0.2, 10, 32.741584, -711.420454, -66.291052},
      {4000, 0, 0, 0, 50, 10, -189.962912, -24.964568, -191.443759},
      {3000, 0.05, -0.08, 0, 0.5, 10, 1986.331585, 2434.250570, -15.990959},
      {5500, -0.1, 0.05, 0.06, -1.0, 10, -5275.481294, -838.524179, 16.320815},
      {2000, 0.0, 0.12, -0.05, 3.0, 10, 1.423754, -1900.769242, -12.537203},
  };
  for (const auto& p : kPoints) {
    const auto f =
        tyre_forces(tyre, point(p.fz_n, p.kappa, p.alpha, p.gamma, p.turn_1pm, p.vx_mps));
    EXPECT_NEAR(f.fx_n, p.fx_n, 1e-3) << p.turn_1pm;
    EXPECT_NEAR(f.fy_n, p.fy_n, 1e-3) << p.turn_1pm;
    EXPECT_NEAR(f.mz_nm, p.mz_nm, 1e-4) << p.turn_1pm;
  }
}

// A wheel that turns on the spot: Mz tends to QCRP1 R0 mu Fz sqrt(Fz / Fz0), (4.95), against the
// turning, and is below it everywhere.
TEST(TurnSlip, ParkingTorqueIsFiniteAndResists) {
  TyreCoefficients tyre = test_car_files().tyre[0];
  tyre.phy1 = tyre.phy2 = tyre.pvy1 = tyre.pvy2 = 0.0;  // shifts act as slip
  tyre.qdz6 = tyre.qdz7 = tyre.qcrp2 = tyre.qbrp1 = 0.0;
  tyre.qdz8 = -0.3;
  const double fz_n = tyre.nominal_load_n;
  const double mu = tyre_forces(tyre, point(fz_n, 0, 0, 0, 0, 0)).mu_y;
  const double most_nm = 0.2 * tyre.unloaded_radius_m * mu * fz_n;
  double before = 0.0;
  for (const double turn_1pm : {0.1, 1.0, 10.0, 1e3, 1e6, 1e300}) {
    const double left = tyre_forces(tyre, point(fz_n, 0, 0, 0, turn_1pm, 0)).mz_nm;
    EXPECT_LT(left, before);
    if (turn_1pm >= 1e6) {
      EXPECT_NEAR(left, -most_nm, 0.02 * most_nm);
    }
    before = turn_1pm < 1e5 ? left : 0.0;
    EXPECT_GT(tyre_forces(tyre, point(fz_n, 0, 0, 0, -turn_1pm, 0)).mz_nm, 0.0);
  }
}

TEST(TurnSlip, IsBitForBitAbsentWithoutTurningAndWithoutCoefficients) {
  const TyreCoefficients with = test_car_files().tyre[0];
  const TyreCoefficients without_it = parse_tyre(test_tyre_text(), "test tyre").coefficients;
  for (const double alpha : {-0.2, 0.0, 0.05})
    for (const double gamma : {-0.05, 0.0, 0.03}) {
      const auto a = tyre_forces(with, point(3000, 0.05, alpha, gamma, 0.0, 20.0));
      const auto b = tyre_forces(without_it, point(3000, 0.05, alpha, gamma, 0.0, 20.0));
      const auto c = tyre_forces(without_it, point(3000, 0.05, alpha, gamma, 2.0, 20.0));
      EXPECT_EQ(a.fx_n, b.fx_n);
      EXPECT_EQ(a.fy_n, b.fy_n);
      EXPECT_EQ(a.mz_nm, b.mz_nm);
      EXPECT_EQ(b.mz_nm, c.mz_nm);
      EXPECT_EQ(b.fy_n, c.fy_n);
    }
}

TEST(TurnSlip, DifferentiatesExactlyAndMirrors) {
  using Jet = ceres::Jet<double, 1>;
  const TyreCoefficients tyre = test_car_files().tyre[0];
  for (const double turn_1pm : {-2.0, -0.1, 0.3, 20.0})
    for (const double gamma : {0.0, 0.04}) {
      const Point in = point(3000, 0.03, 0.05, gamma, turn_1pm, 2.0);
      TyreInput<Jet> along;
      along.fz_n = Jet(in.fz_n);
      along.kappa = Jet(in.kappa);
      along.tan_alpha = Jet(in.tan_alpha);
      along.gamma_rad = Jet(in.gamma_rad);
      along.vx_mps = Jet(in.vx_mps);
      along.turn_1pm = Jet(turn_1pm, 0);
      const auto exact = tyre_forces(tyre, along);
      const double h = 1e-6 * std::abs(turn_1pm);
      Point up = in, down = in;
      up.turn_1pm += h;
      down.turn_1pm -= h;
      const auto high = tyre_forces(tyre, up), low = tyre_forces(tyre, down);
      EXPECT_NEAR(exact.fx_n.v[0], (high.fx_n - low.fx_n) / (2 * h),
                  1e-5 * (1 + std::abs(exact.fx_n.v[0])));
      EXPECT_NEAR(exact.fy_n.v[0], (high.fy_n - low.fy_n) / (2 * h),
                  1e-5 * (1 + std::abs(exact.fy_n.v[0])));
      EXPECT_NEAR(exact.mz_nm.v[0], (high.mz_nm - low.mz_nm) / (2 * h),
                  1e-5 * (1 + std::abs(exact.mz_nm.v[0])));
      Point mirror = in;
      mirror.tan_alpha = -in.tan_alpha;
      mirror.gamma_rad = -in.gamma_rad;
      mirror.turn_1pm = -in.turn_1pm;
      const auto here = tyre_forces(tyre, in),
                 there = tyre_forces(tyre, mirror, {}, {.mirrored = true});
      EXPECT_DOUBLE_EQ(here.fx_n, there.fx_n);
      EXPECT_DOUBLE_EQ(here.fy_n, -there.fy_n);
      EXPECT_DOUBLE_EQ(here.mz_nm, -there.mz_nm);
    }
}

// A car that stands and is steered: both front tyres push the nose against the steering with no
// more than (4.95) each, and the car turns the other way by that torque over the yaw inertia.
TEST(TurnSlip, StandingCarFeelsThatItIsSteered) {
  CarFiles files = test_car_files();
  for (TyreCoefficients& t : files.tyre) t.qdz8 = -0.3;
  const Parameters<double> p = default_parameters();
  const Car<double> car = make_car(files, p, default_amplitudes());
  Simulation<double> sim = start(car, Road(), StartOptions{.gear = 0, .fuel_kg = 0.0});
  Inputs<double> in;
  const auto yaw_torque = [&](double steer_rate_radps) {
    in.steer_rate_radps = steer_rate_radps;
    State<double> rate;
    Detail<double> detail;
    RoadCursors cursors;
    derivative(car, sim.state, in, Road(), cursors, rate, detail);
    return rate[kYawRate] * p[Parameter::chassis_yaw_inertia_kgm2];
  };
  double most_nm = 0.0;
  for (const std::size_t i : {0u, 1u}) {
    const TyreCoefficients& t = files.tyre[0];
    const double fz_n = car.static_load_n[0];
    Point at = point(fz_n, 0, 0, 0, 0, 0);
    most_nm += 0.2 * t.unloaded_radius_m * tyre_forces(t, at).mu_y * fz_n *
               std::sqrt(fz_n / t.nominal_load_n) * (i < 2 ? 1.0 : 0.0);
  }
  const double left = yaw_torque(0.6) - yaw_torque(0.0), right = yaw_torque(-0.6) - yaw_torque(0.0);
  EXPECT_LT(left, -0.3 * most_nm);
  EXPECT_GT(left, -1.1 * most_nm);
  EXPECT_GT(right, 0.3 * most_nm);
  EXPECT_LT(right, 1.1 * most_nm);
}

// Steered to and fro on the spot, brakes on, by both integrators: nothing alternates from step to
// step, the car stays where it is within a centimetre, and heads where it did within half a degree.
TEST(TurnSlip, SteeringOnTheSpotDoesNotChatter) {
  CarFiles files = test_car_files();
  for (TyreCoefficients& t : files.tyre) t.qdz8 = -0.3;
  const Car<double> car = make_car(files, default_parameters(), default_amplitudes());
  for (const Integrator integrator : {Integrator::kSemiImplicit, Integrator::kExplicitEuler}) {
    Simulation<double> sim = start(car, Road(), StartOptions{.gear = 0, .fuel_kg = 0.0});
    StepOptions options;
    options.integrator = integrator;
    Detail<double> detail;
    StepSwing swing;
    double most_nm = 0.0;
    for (int i = 0; i < 6000; ++i) {
      Controls<double> c;
      c.gear_command = 0;
      c.brake_command_pa = {3e6, 3e6, 3e6, 3e6};
      c.steer_command_rad = 0.3 * std::sin(2.0 * M_PI * 0.4 * 0.001 * i);
      const State<double> before = sim.state;
      ASSERT_TRUE(step(car, sim, c, Road(), options, detail).ok());
      swing.look(car, before, detail);
      most_nm = std::max(most_nm, std::abs(dot(detail.wheel[0].couple, detail.wheel[0].normal)));
    }
    EXPECT_EQ(swing.warning(options), "");
    EXPECT_GT(most_nm, 50.0);
    EXPECT_LT(std::hypot(sim.state[kX], sim.state[kY]), 0.01);
    EXPECT_LT(std::abs(sim.state[kYaw]), 0.01);
  }
}

}  // namespace turn_slip_test
