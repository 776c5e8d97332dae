#include "disc_temperature.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "simulated_drive.h"

namespace disc_temperature_test {

using explain_test::Drive;
using vehicle::Parameter;
using vehicle::Term;

std::array<explain::Stop, 2> stops(const Drive& d, const vehicle::Vehicle& car) {
  std::array<explain::Stop, 2> out;
  for (std::size_t k = 0; k < 2; ++k) {
    out[k].axle = k;
    out[k].speed_mps = d.vx_mps;
    out[k].pressure_pa = k == 0 ? d.front_pa : d.rear_pa;
    out[k].disc_k = k == 0 ? d.front_disc_k : d.rear_disc_k;
  }
  const std::vector<double> heat = explain::disc_pad_heat(out, car);
  for (explain::Stop& s : out) s.pad_heat_j = heat;
  return out;
}

/// Error of the worse axle's surface over this drive of 90 s, rms, K; `taken` is the car that is
/// taken for the one that drove.
double error_k(const Drive& d, const vehicle::Vehicle& taken) {
  EXPECT_EQ(d.time_s.size(), 1800u);
  EXPECT_GT(*std::max_element(d.front_disc_k.begin(), d.front_disc_k.end()), 530);
  double most = 0;
  for (const explain::Stop& s : stops(d, taken))
    most = std::max(most, explain_test::apart(explain::disc_temperature(s, taken, {}), s.disc_k));
  return most;
}

// The simulated car at 1 ms is the independent answer: what is left is the step of 50 ms and the
// slip of the braking wheels, which no log of pressures and speed knows. Measured: 0.5 to 2.9 K.
constexpr double kLeft_k = 4.0;

TEST(DiscTemperature, FollowsTheSimulatedDiscs) {
  const vehicle::Vehicle car = explain_test::racer();
  EXPECT_LT(error_k(explain_test::stop_and_go(car, 90), car), kLeft_k);
}

// Every term by its amplitude, one after the other; taken as whole: 9 to 150 K off.
TEST(DiscTemperature, KnowsTheAmplitudesOfTheTerms) {
  for (const Term term : {Term::brake_heating, Term::brake_conduction, Term::brake_convection,
                          Term::brake_heat_capacity, Term::brake_vanes}) {
    vehicle::Vehicle car = explain_test::racer(), whole = car;
    car.terms[term] = 0.4;
    whole.terms[term] = 1.0;
    const auto name = vehicle::term_list()[static_cast<std::size_t>(term)].name;
    const Drive d = explain_test::stop_and_go(car, 90);
    const double error = error_k(d, car);
    EXPECT_LT(error, kLeft_k) << name;
    EXPECT_GT(error_k(d, whole), 3 * error) << name;
  }
}

// Pads that have lost up to half of their bite heat their discs less.
TEST(DiscTemperature, KnowsTheFadeOfThePads) {
  vehicle::Vehicle car = explain_test::racer();
  car.parameters[Parameter::brake_fade_1pmj] = 1.0;
  car.parameters[Parameter::brake_fade_s] = 20;
  for (const double amount : {1.0, 0.5}) {
    car.terms[Term::brake_fade] = amount;
    const Drive d = explain_test::stop_and_go(car, 90);
    const auto axles = stops(d, car);
    const double most = *std::max_element(d.pad_heat_j.begin(), d.pad_heat_j.end());
    EXPECT_GT(most, 2e5);
    EXPECT_LT(explain_test::apart(axles[0].pad_heat_j, d.pad_heat_j), 0.05 * most) << amount;
    vehicle::Vehicle blind = car;
    blind.terms[Term::brake_fade] = 0;
    const double error = error_k(d, car);
    EXPECT_LT(error, kLeft_k) << amount;
    EXPECT_GT(error_k(d, blind), 3 * error) << amount;
  }
}

// A disc that was not logged at the begin starts with the first sample; no pads that fade, no heat.
TEST(DiscTemperature, BeginsWithTheFirstLoggedTemperature) {
  const vehicle::Vehicle car = explain_test::racer();
  explain::Stop s;
  s.disc_k = {NAN, NAN, 450, NAN};
  s.speed_mps = {30, NAN, 30, 30};
  s.pressure_pa = {NAN, NAN, NAN, NAN};
  const std::vector<double> t = explain::disc_temperature(s, car, {});
  ASSERT_EQ(t.size(), 4u);
  EXPECT_TRUE(std::isnan(t[0]) && std::isnan(t[1]));
  EXPECT_EQ(t[2], 450);
  EXPECT_LT(t[3], 450);
  EXPECT_TRUE(explain::disc_pad_heat({s, s}, car).empty());
}

}  // namespace disc_temperature_test
