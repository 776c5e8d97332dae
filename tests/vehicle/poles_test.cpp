#include "vehicle/poles.h"

#include <gtest/gtest.h>

#include <cmath>

#include "test_car.h"

namespace {

using namespace vehicle;  // NOLINT: a test of this library

// A wheel that only has its tyre's carcass to swing against: sqrt(C r^2 / I), almost undamped at
// low speed. Explicit Euler cannot do that at 1 ms, and less at 1.2 ms; the default step can.
TEST(Poles, ShowTheWheelSpinThatExplicitEulerCannotDoAtLowSpeed) {
  const CarFiles files = test_car_files();
  const Car<double> car = make_car(files, default_parameters(), default_amplitudes());
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

TEST(Poles, AreStableForTheDefaultStepAtEverySpeed) {
  const CarFiles files = test_car_files();
  const Car<double> car = make_car(files, default_parameters(), default_amplitudes());
  for (const double speed : {0.5, 2.0, 10.0, 30.0, 60.0})
    for (const auto& radius : linearise(car, speed, {0.001}).radii)
      EXPECT_LT(radius.semi_implicit, 1.0) << speed;
}

}  // namespace
