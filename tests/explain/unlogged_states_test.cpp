// States of the car that hardly a log has: each mechanism works out its own.
#include <gtest/gtest.h>

#include <algorithm>

#include "mechanism.h"
#include "simulated_drive.h"
#include "standing_car.h"

namespace unlogged_states_test {

using explain_test::Drive;
using vehicle::Parameter;
using vehicle::Term;

recording::Recording recording_of(const Drive& d) {
  recording::Recording out;
  out.table.add("time_s", d.time_s);
  out.table.add("vx_mps", d.vx_mps);
  out.table.add("yaw_rate_radps", d.yaw_rate_radps);
  out.table.add("throttle", d.throttle);
  out.table.add("engine_radps", d.engine_radps);
  for (const char* wheel : {"fl", "fr"})
    out.table.add(std::string("brake_") + wheel + "_pa", d.front_pa);
  for (const char* wheel : {"rl", "rr"})
    out.table.add(std::string("brake_") + wheel + "_pa", d.rear_pa);
  return out;
}

double most(const std::vector<double>& x) { return *std::max_element(x.begin(), x.end()); }

vehicle::Vehicle forgetful() {
  vehicle::Vehicle car = explain_test::racer();
  car.parameters[Parameter::brake_fade_1pmj] = 1.0;
  car.parameters[Parameter::tyre_warm_up_loss] = 0.1;
  // No map of the pads' friction: a log without disc temperatures does not know where on it.
  car.terms[Term::brake_friction_temperature] = 0.0;
  return car;
}

// What the simulated car did at 1 ms comes out of its log of 20 Hz, also where half of a term acts.
TEST(UnloggedStates, AreThoseOfTheSimulatedCar) {
  for (const double amount : {1.0, 0.5}) {
    vehicle::Vehicle car = forgetful();
    car.terms[Term::brake_fade] = amount;
    const Drive d = explain_test::stop_and_go(car, 60);
    recording::Recording log = recording_of(d);
    explain::add_unlogged_states(log, car);
    const auto *boost = log.table.find("boost"), *heat = log.table.find("pad_heat_j"),
               *warmth = log.table.find("tyre_warmth");
    ASSERT_TRUE(boost != nullptr && heat != nullptr && warmth != nullptr);
    EXPECT_GT(most(d.pad_heat_j), 2e5);
    EXPECT_LT(explain_test::apart(*heat, d.pad_heat_j), 0.05 * most(d.pad_heat_j)) << amount;
    if (amount < 1) {  // a whole term would lose more bite and take up less heat
      recording::Recording other = recording_of(d);
      explain::add_unlogged_states(other, forgetful());
      EXPECT_GT(explain_test::apart(*other.table.find("pad_heat_j"), d.pad_heat_j),
                3 * explain_test::apart(*heat, d.pad_heat_j));
    }
    EXPECT_LT(explain_test::apart(*warmth, d.tyre_warmth), 0.02 * most(d.tyre_warmth));
    // The log begins settled, the simulation without boost: alike from then on.
    std::vector<double> late(boost->begin() + 40, boost->end()),
        simulated(d.boost.begin() + 40, d.boost.end());
    EXPECT_LT(explain_test::apart(late, simulated), 0.1);
    EXPECT_GT(most(d.boost), 0.7);
  }
}

TEST(UnloggedStates, AreLeftOutWhereTheCarHasNone) {
  vehicle::Vehicle car = forgetful();
  car.terms[Term::turbo_lag] = car.terms[Term::brake_fade] = car.terms[Term::tyre_warm_up] = 0.0;
  recording::Recording log = recording_of(explain_test::stop_and_go(car, 2));
  explain::add_unlogged_states(log, car);
  for (const char* name : {"boost", "pad_heat_j", "tyre_warmth"})
    EXPECT_EQ(log.table.find(name), nullptr) << name;
}

// The car's own rolling radius: 100 rad/s of wheels that roll freely.
TEST(UnloggedStates, RollOnTheStandingCarsRadius) {
  const vehicle::Vehicle v = explain_test::racer();
  const auto car = vehicle::make_car(v.files, v.parameters, v.terms, v.contact);
  vehicle::StartOptions begin;
  begin.speed_mps = 20;
  begin.gear = 0;
  const auto sim = vehicle::start(car, vehicle::Road(), begin);
  for (std::size_t axle = 0; axle < 2; ++axle)
    EXPECT_NEAR(explain::standing_radius_m(v, axle) * sim.state[vehicle::kSpin + 2 * axle], 20,
                1e-9);
}

}  // namespace unlogged_states_test
