#include "vehicle/laws/actuator_friction.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "test_car.h"

namespace actuator_friction_test {

using namespace vehicle;  // NOLINT: a test of this library
using P = Parameter;

/// Corners of a loop, drawn by hand: drive and output.
using Loop = std::vector<std::pair<double, double>>;

/// The drive goes in straight lines from corner to corner, in many small steps.
template <class Move>
void expect_loop(const Loop& loop, Move&& move) {
  double drive = 0;
  for (const auto& [corner, output] : loop) {
    constexpr int kSteps = 1000;
    double got = 0;
    for (int i = 1; i <= kSteps; ++i) got = move(drive + (corner - drive) * i / kSteps);
    drive = corner;
    EXPECT_NEAR(got, output, 1e-12) << "at " << corner;
  }
}

// Half width 1: to 5 the output comes to 4; back to 3 nothing moves; to -2 it comes to -1; a small
// loop from -2 to -0.5 and back leaves it; then up again.
TEST(ActuatorFriction, PlaysAsTheHandDrawnLoop) {
  double output = 0;
  expect_loop(
      {{0.9, 0}, {5, 4}, {3, 4}, {2.5, 3.5}, {-2, -1}, {-0.5, -1}, {-2, -1}, {2, 1}, {5, 4}},
      [&](double drive) {
        laws::play(drive, 1.0, output);
        return output;
      });
}

// Sliding 1, break-away 0.5 more: nothing up to 1.5, then behind by 1. Held still it sticks: 0.4
// more does not move it, 0.6 does. It turns after 1 + 1 + 0.5 of way back.
TEST(ActuatorFriction, SticksAsTheHandDrawnLoop) {
  laws::Stick<double> s;
  const auto move = [&](double drive) {
    laws::stick(drive, 1.0, 0.5, s);
    return s.output;
  };
  expect_loop({{1.499, 0}, {1.51, 0.51}, {4, 3}}, move);
  for (int i = 0; i < 3; ++i) move(4);
  EXPECT_EQ(s.moving, 0);
  const double at = s.output;
  EXPECT_EQ(move(4.4), at);
  EXPECT_NEAR(move(4.6), 3.6, 1e-12);
  expect_loop({{4.6, 3.6}}, move);
  s = {3.6, 4.6, 0};
  const auto back = [&](double drive) { return move(drive); };
  for (const auto& [drive, output] : Loop{{4.0, 3.6},
                                          {2.2, 3.6},
                                          {2.11, 3.6},
                                          {2.05, 3.05},
                                          {0, 1},
                                          {-3, -2},
                                          {-1.6, -2},
                                          {-0.4, -1.4}}) {
    EXPECT_NEAR(back(drive), output, 1e-12) << drive;
  }
  // Without a break-away it is the play operator.
  laws::Stick<double> plain;
  double play = 0;
  for (int i = 0; i < 2000; ++i) {
    const double drive = 3 * std::sin(0.01 * i) + std::sin(0.037 * i);
    laws::stick(drive, 0.7, 0.0, plain);
    laws::play(drive, 0.7, play);
    EXPECT_NEAR(plain.output, play, 1e-12);
  }
}

template <class T>
Inputs<T> drive_actuators(const Car<T>& car, int steps) {
  Discrete<T> d;
  Inputs<T> in;
  for (int i = 0; i < steps; ++i) {
    Controls<T> c;
    c.steer_command_rad = T(0.05 * std::sin(0.02 * i));
    c.throttle_command = T(0.5 - 0.5 * std::cos(0.015 * i));
    for (T& pressure : c.brake_command_pa) pressure = T(2e6 * (1 - std::cos(0.015 * i)));
    in = actuate(car, d, c, 0.001);
  }
  return in;
}

// In the car: command, actuator, friction with break-away, backlash; in steady sliding the road
// wheels are behind by the sum of friction and half the play, the brakes by their friction.
TEST(ActuatorFriction, HoldsSteeringAndBrakesBack) {
  const CarFiles files = test_car_files();
  Parameters<double> p = default_parameters();
  p[P::steering_friction_rad] = 0.001;
  Amplitudes<double> terms = default_amplitudes();
  terms[Term::steering_actuator] = terms[Term::brake_actuator] = 0.0;
  const auto at = [&](int steps) { return drive_actuators(make_car(files, p, terms), steps); };
  const Inputs<double> before = at(60);
  p[P::steering_breakaway_rad] = 0.002;
  p[P::steering_backlash_rad] = 0.004;
  p[P::brake_friction_pa] = 5e4;
  p[P::brake_breakaway_pa] = 1e5;
  const Inputs<double> sticking = at(60);
  EXPECT_NEAR(sticking.steer_rad, 0.05 * std::sin(0.02 * 59) - 0.001 - 0.002, 1e-12);
  EXPECT_NEAR(sticking.brake_pa[0], 2e6 * (1 - std::cos(0.015 * 59)) - 5e4, 1e-6);
  EXPECT_EQ(at(3).brake_pa[1], 0.0);
  terms[Term::steering_backlash] = terms[Term::brake_friction] = 0.0;
  const Inputs<double> off = at(60);
  EXPECT_EQ(off.brake_pa[0], before.brake_pa[0]);
  EXPECT_NEAR(off.steer_rad, before.steer_rad, 1e-15);
}

// The same of the throttle, by hand: opening, it is behind by its friction; at rest it stays shut
// until friction and break-away are overcome; closing, it is ahead. Switched off: as asked.
TEST(ActuatorFriction, HoldsTheThrottleBack) {
  const CarFiles files = test_car_files();
  Parameters<double> p = default_parameters();
  Amplitudes<double> terms = default_amplitudes();
  terms[Term::throttle_actuator] = 0.0;
  const auto at = [&](int steps) {
    return drive_actuators(make_car(files, p, terms), steps).throttle;
  };
  const auto asked = [](int steps) { return 0.5 - 0.5 * std::cos(0.015 * (steps - 1)); };
  EXPECT_EQ(at(100), asked(100));
  p[P::throttle_friction] = 0.02;
  p[P::throttle_breakaway] = 0.03;
  EXPECT_LT(asked(30), 0.05);
  EXPECT_EQ(at(30), 0.0);
  EXPECT_GT(asked(32), 0.05);
  EXPECT_NEAR(at(32), asked(32) - 0.02, 1e-15);
  EXPECT_NEAR(at(150), asked(150) - 0.02, 1e-15);
  EXPECT_NEAR(at(211), asked(211) - 0.02, 1e-4);  // turns at step 210: sticks
  EXPECT_NEAR(at(330), asked(330) + 0.02, 1e-15);
  terms[Term::throttle_friction] = 0.5;
  EXPECT_NEAR(at(150), asked(150) - 0.01, 1e-15);
  terms[Term::throttle_friction] = 0.0;
  EXPECT_EQ(at(150), asked(150));
}

TEST(ActuatorFriction, HasExactDerivatives) {
  using Jet = ceres::Jet<double, 1>;
  const CarFiles files = test_car_files();
  Parameters<double> p = default_parameters();
  p[P::steering_breakaway_rad] = 0.002;
  p[P::steering_backlash_rad] = 0.004;
  p[P::brake_friction_pa] = 5e4;
  p[P::brake_breakaway_pa] = 1e5;
  p[P::throttle_friction] = 0.02;
  p[P::throttle_breakaway] = 0.01;
  for (const P which : {P::steering_friction_rad, P::steering_backlash_rad, P::brake_friction_pa,
                        P::steering_lag_s, P::throttle_friction, P::throttle_lag_s}) {
    Parameters<Jet> pj;
    Amplitudes<Jet> tj;
    const Amplitudes<double> terms = default_amplitudes();
    for (std::size_t i = 0; i < kParameterCount; ++i) pj.value[i] = Jet(p.value[i]);
    for (std::size_t i = 0; i < kTermCount; ++i) tj.value[i] = Jet(terms.value[i]);
    pj[which].v[0] = 1.0;
    const Inputs<Jet> jet = drive_actuators(make_car<Jet>(files, pj, tj), 130);
    const double h = 1e-4 * p[which];
    Parameters<double> up = p, down = p;
    up[which] += h;
    down[which] -= h;
    const Inputs<double> a = drive_actuators(make_car(files, up, terms), 130);
    const Inputs<double> b = drive_actuators(make_car(files, down, terms), 130);
    const double steer = (a.steer_rad - b.steer_rad) / (2 * h);
    const double brake = (a.brake_pa[2] - b.brake_pa[2]) / (2 * h);
    EXPECT_NEAR(jet.steer_rad.v[0], steer, 1e-5 * std::abs(steer) + 1e-9);
    EXPECT_NEAR(jet.brake_pa[2].v[0], brake, 1e-5 * std::abs(brake) + 1e-6);
    const double throttle = (a.throttle - b.throttle) / (2 * h);
    EXPECT_NEAR(jet.throttle.v[0], throttle, 1e-5 * std::abs(throttle) + 1e-9);
    EXPECT_NE(std::abs(steer) + std::abs(brake) + std::abs(throttle), 0.0);
  }
}

}  // namespace actuator_friction_test
