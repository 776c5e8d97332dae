#include "vehicle/actuator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

#include "test_car.h"
#include "vehicle/error.h"

namespace {

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

TEST(Actuator, IsTheArxModelOfItsCoefficients) {
  std::mt19937 random(5);
  std::vector<double> command;
  for (int k = 0; k < 400; ++k) command.push_back(static_cast<double>(random() % 1000) / 1e3);
  for (const double damping : {0.3, 1.0, 3.0}) {
    const auto got = response(steering(1.0, 0.004, 0.02, damping, -0.005), command);
    const ArxCoefficients c = arx_of({1.0, 0.004, 0.02, damping, -0.005}, 0.001);
    for (std::size_t k = 6; k < command.size(); ++k)
      EXPECT_NEAR(
          got[k],
          c.a1 * got[k - 1] + c.a2 * got[k - 2] + c.b0 * command[k - 4] + c.b1 * command[k - 5],
          1e-12);
  }
}

TEST(Actuator, IsFoundFromItsRecordedMovement) {
  std::vector<double> time, command;
  for (int k = 0; k < 20000; ++k) {  // a chirp, as crgdrive manoeuvre drives it
    const double t = 0.001 * k;
    time.push_back(t);
    command.push_back(0.03 * std::sin(2 * 3.14159265358979 * (0.2 * t + 0.2 * t * t)));
  }
  const auto full = response(steering(1.25, 0.035, 0.04, 0.6, 0.01), command);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 2e-4);
  std::vector<double> t, u, y;
  for (std::size_t k = 0; k < time.size(); k += 10) {  // recorded at 100 Hz, with noise
    t.push_back(time[k]);
    u.push_back(command[k]);
    y.push_back(full[k] + noise(random));
  }
  const ActuatorModel m = identify_actuator(t, u, y);
  std::printf(
      "gain %.4f, dead time %.4f s, lag %.4f s, damping %.3f, lead %.4f s, rms %.2e of %.2e\n",
      m.gain, m.dead_time_s, m.lag_s, m.damping, m.lead_s, m.rms, m.rms_plain);
  // Measured: 0.7995, 36.2 ms, 40.2 ms, 0.600, 11.6 ms. Dead time and lead are hard to tell apart
  // in noise, what they do together is not; bounds are twice the errors measured.
  EXPECT_NEAR(m.gain, 1 / 1.25, 2e-3);
  EXPECT_NEAR(m.dead_time_s, 0.035, 2.4e-3);
  EXPECT_NEAR(m.dead_time_s - m.lead_s, 0.025, 1e-3);
  EXPECT_NEAR(m.lag_s, 0.04, 1e-3);
  EXPECT_NEAR(m.damping, 0.6, 0.02);
  EXPECT_NEAR(m.lead_s, 0.01, 3.2e-3);
  EXPECT_NEAR(m.rms, 2e-4, 2e-5);
}

TEST(Actuator, RefusesWhatSaysNothing) {
  const std::vector<double> few(20, 0.0);
  EXPECT_THROW(identify_actuator(few, few, few), Error);
  std::vector<double> time, still(200, 0.3), moving;
  for (int k = 0; k < 200; ++k) {
    time.push_back(0.01 * k);
    moving.push_back(std::sin(0.1 * k));
  }
  EXPECT_THROW(identify_actuator(time, still, moving), Error);
  moving[3] = NAN;
  EXPECT_THROW(identify_actuator(time, moving, still), Error);
}

}  // namespace
