// The law of the actuators, in the car; what finds them from a record is tested in tests/identify.
#include <gtest/gtest.h>

#include <cmath>

#include "test_car.h"

namespace actuator_test {

using namespace vehicle;  // NOLINT: a test of this library
using P = Parameter;

/// Response of the actuator in the car, ms by ms.
std::vector<double> response(const Parameters<double>& p, const std::vector<double>& command) {
  const CarFiles files = test_car_files();
  Amplitudes<double> terms = default_amplitudes();
  terms[Term::steering_friction] = 0.0;
  const Car<double> car = make_car(files, p, terms);
  Discrete<double> d{};
  Controls<double> controls;
  std::vector<double> out;
  for (const double c : command) {
    controls.steer_command_rad = c;
    out.push_back(actuate(car, d, controls, 0.001).steer_rad);
  }
  return out;
}

Parameters<double> steering(double ratio, double dead_s, double lag_s, double damping,
                            double lead_s) {
  Parameters<double> p = default_parameters();
  p[P::steering_ratio] = ratio;
  p[P::steering_dead_time_s] = dead_s;
  p[P::steering_lag_s] = lag_s;
  p[P::steering_damping] = damping;
  p[P::steering_lead_s] = lead_s;
  return p;
}

// The step response of a second-order system, from any textbook: under-, critically and overdamped.
TEST(Actuator, RespondsToAStepAsTheClosedForm) {
  const std::vector<double> command(300, 1.0);
  for (const double damping : {0.2, 0.7, 0.9999, 1.0, 1.0001, 1.5, 8.0}) {
    const double lag = 0.03, lead = 0.01;
    const auto got = response(steering(1.0, 0.0, lag, damping, lead), command);
    for (std::size_t k = 0; k < got.size(); ++k) {
      const double t = 0.001 * static_cast<double>(k + 1), x = t / lag;
      double y = 0, rate = 0;
      if (std::abs(damping - 1.0) < 1e-3) {
        y = 1 - (1 + x) * std::exp(-x);
        rate = x / lag * std::exp(-x);
      } else if (damping < 1.0) {
        const double w = std::sqrt(1 - damping * damping);
        y = 1 - std::exp(-damping * x) * (std::cos(w * x) + damping / w * std::sin(w * x));
        rate = std::exp(-damping * x) / (w * lag) * std::sin(w * x);
      } else {
        const double w = std::sqrt(damping * damping - 1);
        const double p1 = (damping - w) / lag, p2 = (damping + w) / lag;
        y = 1 - (p2 * std::exp(-p1 * t) - p1 * std::exp(-p2 * t)) / (p2 - p1);
        rate = p1 * p2 / (p2 - p1) * (std::exp(-p1 * t) - std::exp(-p2 * t));
      }
      const double tolerance = std::abs(damping - 1.0) < 1e-3 ? 1e-4 : 1e-10;
      EXPECT_NEAR(got[k], y + lead * rate, tolerance) << damping << " " << t;
    }
  }
}

// A pressure that has decayed ends in zero: never in a number that only few programs read.
TEST(Actuator, WhatHasDecayedIsZero) {
  std::vector<double> command(20000, 0.0);
  for (std::size_t i = 0; i < 100; ++i) command[i] = 1.0;
  const auto out = response(steering(1.0, 0.0, 0.01, 1.0, 0.0), command);
  for (const double x : out) EXPECT_TRUE(x == 0.0 || std::isnormal(x)) << x;
  EXPECT_GT(out[99], 0.9);
  EXPECT_EQ(out.back(), 0.0);
}

}  // namespace actuator_test
