// Driving backward: reverse gear, steering, tyres.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "test_car.h"
#include "vehicle/error.h"
#include "vehicle/manoeuvre.h"
#include "vehicle/work.h"

namespace reverse_test {

using namespace vehicle;  // NOLINT: a test of this library
using P = Parameter;

Parameters<double> with_reverse() {
  Parameters<double> p = default_parameters();
  p[P::gearbox_ratio_reverse] = 3.5;
  return p;
}

// By hand: torque of the clutch times 3.5 times the final drive times the efficiency, backward.
TEST(Reverse, DrivesTheWheelsBackwardByItsRatio) {
  const CarFiles files = test_car_files();
  const Parameters<double> p = with_reverse();
  const Car<double> car = make_car(files, p, default_amplitudes());
  Simulation<double> sim = start(car, Road(), StartOptions{.speed_mps = -4.0, .gear = -1});
  EXPECT_GT(sim.state[kEngine], 0.0);
  sim.state[kEngine] = 400.0;
  Inputs<double> in;
  in.gear = -1;
  in.throttle = 1.0;
  State<double> rate;
  Detail<double> detail;
  RoadCursors cursors;
  derivative(car, sim.state, in, Road(), cursors, rate, detail);
  EXPECT_GT(detail.clutch_nm, 100.0);
  const double by_hand_nm =
      -detail.clutch_nm * 3.5 * p[P::gearbox_final] * p[P::gearbox_efficiency];
  EXPECT_NEAR(detail.wheel[2].drive_nm + detail.wheel[3].drive_nm, by_hand_nm, 1e-9 * -by_hand_nm);
}

// Backward at a steady 3 m/s, steered to the left: the kinematic bicycle turns clockwise by
// v tan(steer) / wheelbase, and the energy account closes.
TEST(Reverse, TurnsTheOtherWayAndKeepsItsEnergyBalance) {
  const CarFiles files = test_car_files();
  Parameters<double> p = with_reverse();
  p[P::environment_wind_mps] = 0.0;
  p[P::steering_ackermann] = 0.0;
  const Car<double> car = make_car(files, p, default_amplitudes());
  Simulation<double> sim = start(car, Road(), StartOptions{.gear = -1});
  Controls<double> c;
  c.gear_command = -1;
  Detail<double> detail;
  const double before_j = energy(car, sim.state);
  double work_j = 0.0, engine_j = 0.0;
  for (int i = 0; i < 12000; ++i) {
    c.throttle_command = std::clamp(0.2 + 0.3 * (3.0 + sim.state[kVx]), 0.0, 1.0);
    c.steer_command_rad = i > 6000 ? 0.1 : 0.0;
    const State<double> state = sim.state;
    ASSERT_TRUE(step(car, sim, c, Road(), {}, detail).ok());
    const Powers<double> work = work_of_step(car, state, sim.state, detail, {});
    work_j += work.sum();
    engine_j += work.engine;
  }
  ASSERT_LT(sim.state[kVx], -1.5);
  const double by_hand = sim.state[kVx] * std::tan(0.1) / p[P::chassis_wheelbase_m];
  EXPECT_NEAR(sim.state[kYawRate], by_hand, 0.03 * -by_hand);
  EXPECT_NEAR(energy(car, sim.state) - before_j, work_j, 2e-4 * engine_j);
}

// Backward, slip and side slip are resisted as forward, and the trail lies on the other side.
TEST(Reverse, TyresResistSlipEitherWay) {
  const TyreCoefficients tyre = symmetric_tyre();
  for (const double alpha : {-0.05, 0.05}) {
    const auto forward =
        tyre_forces(tyre, TyreInput<double>{3000, 0.02, std::tan(alpha), 0, 20.0, 0});
    const auto backward =
        tyre_forces(tyre, TyreInput<double>{3000, 0.02, std::tan(alpha), 0, -20.0, 0});
    EXPECT_EQ(forward.fx_n, backward.fx_n);
    EXPECT_EQ(forward.fy_n, backward.fy_n);
    EXPECT_LT(forward.fy_n * alpha, 0.0);
    EXPECT_GT(forward.mz_nm * alpha, 0.0);
    EXPECT_LT(backward.mz_nm * alpha, 0.0);
    EXPECT_GT(backward.my_nm, 0.0);
  }
}

TEST(Reverse, ManoeuvreDrivesBackwardOrSaysWhyNot) {
  const CarFiles files = test_car_files();
  Manoeuvre m;
  m.kind = manoeuvre_named("reverse");
  m.speed_mps = 4.0;
  m.duration_s = 10.0;
  m.steer_rad = 0.1;
  const ManoeuvreResult r = run_manoeuvre(make_car(files, with_reverse(), default_amplitudes()), m);
  ASSERT_TRUE(r.complete) << r.problem;
  EXPECT_NEAR(r.end_mps, -4.0, 1.0);
  EXPECT_EQ(r.telemetry.find("gear")->back(), -1.0);
  EXPECT_LT(r.telemetry.find("yaw_rate_radps")->back(), -0.05);
  EXPECT_EQ(r.swing_warning, "");
  EXPECT_THAT(
      [&] { run_manoeuvre(make_car(files, default_parameters(), default_amplitudes()), m); },
      ::testing::ThrowsMessage<Error>(::testing::HasSubstr("no reverse gear")));
}

}  // namespace reverse_test
