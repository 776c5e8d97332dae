#include "vehicle/poles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "test_car.h"

namespace poles_test {

using namespace vehicle;  // NOLINT: a test of this library

// A wheel that only has its tyre's carcass to swing against: sqrt(C r^2 / I), almost undamped at
// low speed. Explicit Euler cannot do that at 1 ms, and less at 1.2 ms; the default step can.
TEST(Poles, ShowTheWheelSpinThatExplicitEulerCannotDoWithoutCarcassDamping) {
  const CarFiles files = test_car_files();
  Amplitudes<double> terms = default_amplitudes();
  terms[Term::tyre_carcass_damping] = 0.0;
  const Car<double> car = make_car(files, default_parameters(), terms);
  const Linearisation slow = linearise(car, 4.0, {0.001, 0.0012});
  ASSERT_EQ(slow.radii.size(), 2u);
  EXPECT_GT(slow.radii[0].explicit_euler, 1.0);
  EXPECT_GT(slow.radii[1].explicit_euler, slow.radii[0].explicit_euler);
  EXPECT_LT(slow.radii[0].semi_implicit, 1.0);
  EXPECT_LT(slow.radii[1].semi_implicit, 1.0);
  EXPECT_LT(slow.euler_step_s, 0.001);
  const double inertia = car.parameters[Parameter::front_wheel_inertia_kgm2];
  const double swing = std::sqrt(300000.0 * 0.29 * 0.29 / inertia);
  bool found = false;
  for (const Pole& pole : slow.poles)
    found = found || std::abs(pole.imaginary_radps / swing - 1.0) < 0.1;
  EXPECT_TRUE(found);
}

TEST(Poles, AreStableForBothIntegratorsAtEverySpeed) {
  const CarFiles files = test_car_files();
  for (const Parameters<double>& p : {default_parameters(), test_parameters()}) {
    const Car<double> car = make_car(files, p, default_amplitudes());
    for (const double speed : {0.5, 2.0, 5.5, 10.0, 30.0, 60.0}) {
      const Linearisation at = linearise(car, speed, {0.001, 0.0012});
      EXPECT_GT(at.euler_step_s, 0.002) << speed;
      for (const auto& radius : at.radii) {
        EXPECT_LT(radius.semi_implicit, 1.0) << speed;
        EXPECT_LT(radius.explicit_euler, 1.0) << speed;
      }
    }
  }
}

/// The car held at a walking pace by explicit Euler: how far the force of a driven wheel still
/// swings in the sixth second, N.
double swing_at_low_speed_n(double step_s, double carcass_damping) {
  const CarFiles files = test_car_files();
  Amplitudes<double> terms = default_amplitudes();
  terms[Term::tyre_carcass_damping] = carcass_damping;
  const Car<double> car = make_car(files, default_parameters(), terms);
  const Road road;
  StartOptions begin;
  begin.speed_mps = 5.5;
  Simulation<double> sim = start(car, road, begin);
  Detail<double> detail;
  StepOptions options;
  options.step_s = step_s;
  options.integrator = Integrator::kExplicitEuler;
  Controls<double> controls;
  double least = 1e9, most = -1e9;
  while (sim.time_s < 6.0) {
    controls.throttle_command = std::clamp(0.1 * (5.5 - sim.state[kVx]), 0.0, 0.2);
    EXPECT_TRUE(step(car, sim, controls, road, options, detail).ok());
    if (sim.time_s < 5.0) continue;
    least = std::min(least, detail.wheel[0].fx_n);
    most = std::max(most, detail.wheel[0].fx_n);
  }
  return most - least;
}

// What the finding about the longer step is in this car: without loss in the carcass the wheel's
// swing grows at low speed, more at 1.2 ms than at 1 ms, until the tyre's friction bounds it.
TEST(Poles, TellWhatHappensInTime) {
  const double bare = swing_at_low_speed_n(0.001, 0.0), longer = swing_at_low_speed_n(0.0012, 0.0);
  const double damped = swing_at_low_speed_n(0.001, 1.0),
               damped_longer = swing_at_low_speed_n(0.0012, 1.0);
  std::printf("front wheel at 5.5 m/s: %.0f N at 1 ms, %.0f N at 1.2 ms; damped %.2f N, %.2f N\n",
              bare, longer, damped, damped_longer);
  EXPECT_GT(bare, 100.0);
  EXPECT_GT(longer, bare);
  EXPECT_LT(damped, 2.0);
  EXPECT_LT(damped_longer, 2.0);
}

}  // namespace poles_test
