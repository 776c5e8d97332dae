#include "explain/judge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "explain/gyro_or_banking.h"
#include "explain/wheels_say.h"

namespace explain {
namespace judge_test {

Finding found(bool separable) {
  Finding f;
  f.mechanism = "vehicle.turbo_lag";
  f.rivals.push_back({"vehicle.throttle_dead_time", "", "", 0.0, separable});
  return f;
}

TEST(Judge, SaysTheStrongestClaimThatHoldsForTheWhole) {
  Findings all;
  EXPECT_EQ(judge(all), Verdict::kNone);
  all.findings = {found(true)};
  EXPECT_EQ(judge(all), Verdict::kExplained);
  all.unexplained.emplace_back();
  EXPECT_EQ(judge(all), Verdict::kUnknown);
  // A finding that may be another one, whatever is left beside it.
  all.findings.push_back(found(false));
  EXPECT_EQ(judge(all), Verdict::kTie);
  // Of another car nothing is known.
  all.doubtful_car = true;
  EXPECT_EQ(judge(all), Verdict::kUnknown);
}

TEST(Judge, AGyroThatShowsTooLittleMayBeARoadThatLeans) {
  Signals log;
  log.present[kYawRate] = log.present[kAy] = true;
  log.column[kYawRate] = "gyro_z";
  Findings all;
  Finding gain;
  gain.mechanism = "sensor.gain";
  gain.channel = "gyro_z";
  gain.parameters.push_back({"gain error", "1", -0.047, -0.05, -0.044});
  all.findings = {gain};
  tie_gain_with_banking(log, all);
  EXPECT_EQ(judge(all), Verdict::kTie) << "the lateral speed is not logged";
  EXPECT_FALSE(all.findings[0].not_used.empty());
  EXPECT_EQ(all.findings[0].mechanism, "road.banking");
  EXPECT_EQ(all.findings[0].rivals.at(0).mechanism, "sensor.gain");
  EXPECT_NEAR(std::cos(std::atan(all.findings[0].parameters[0].value)), 1 - 0.047, 1e-9);
  // No road makes a gyro show more, and with all channels the bank shows by itself.
  all.findings = {gain};
  all.findings[0].parameters[0].value = 0.047;
  tie_gain_with_banking(log, all);
  EXPECT_EQ(judge(all), Verdict::kExplained);
  all.findings = {gain};
  log.present[kVy] = true;
  tie_gain_with_banking(log, all);
  EXPECT_EQ(judge(all), Verdict::kExplained);
  EXPECT_TRUE(all.findings[0].not_used.empty());
}

TEST(Judge, SomethingLeftAloneIsUnknown) {
  Findings all;
  all.unexplained.emplace_back();
  EXPECT_EQ(judge(all), Verdict::kUnknown);
}

TEST(Judge, NothingIsGreenBesideAParameterThatIsOffAndNotNamed) {
  Findings all;
  all.parameters.push_back({"parameter.drag", "aero.drag_area_m2", "m2", 0.665, 0.93, 0.9, 0.96});
  EXPECT_EQ(judge(all), Verdict::kNone) << "within its prior";
  all.parameters[0].beyond_prior = true;
  EXPECT_EQ(judge(all), Verdict::kUnknown);
  all.parameters[0].beyond_prior = false;
  all.parameters[0].at_limit = true;
  EXPECT_EQ(judge(all), Verdict::kUnknown);
  all.parameters[0].at_limit = false;
  all.parameters[0].unsure = true;
  EXPECT_EQ(judge(all), Verdict::kUnknown);
  Finding drag;
  drag.mechanism = "parameter.drag";
  drag.parameters.push_back({"aero.drag_area_m2", "m2", 0.93, 0.9, 0.96});
  all.findings = {drag};
  EXPECT_EQ(judge(all), Verdict::kExplained);
}

TEST(Judge, HasTheWordsOfTheFormat) {
  EXPECT_STREQ(name_of(Verdict::kNone), "none");
  EXPECT_STREQ(name_of(Verdict::kExplained), "explained");
  EXPECT_STREQ(name_of(Verdict::kTie), "tie");
  EXPECT_STREQ(name_of(Verdict::kUnknown), "unknown");
}

/// Turns of both ways by a car whose driven wheels, in m/s, do `share` less than that asks for.
Signals turning_log(double share) {
  Signals log;
  log.n = 2000;
  log.wheels_in_mps = true;
  for (const Channel c : {kVx, kYawRate, kSteer, kWheelRear, kWheelRearDifference})
    log.present[c] = true, log.x[c].assign(log.n, 0.0);
  log.column[kSteer] = "delta", log.column[kVx] = "vx", log.column[kWheelRear] = "rear";
  for (std::size_t i = 0; i < log.n; ++i) {
    const double rate = 0.2 * std::sin(0.01 * static_cast<double>(i)),
                 speed = 20.0 + 8.0 * std::sin(0.004 * static_cast<double>(i));
    log.x[kVx][i] = log.x[kWheelRear][i] = speed;
    log.x[kYawRate][i] = rate;
    log.x[kWheelRearDifference][i] =
        -1.6 * rate * (1 - share) + 0.02 * std::sin(0.7 * static_cast<double>(i * i % 997));
  }
  return log;
}

Findings found_at(const char* id, const char* column, double amount) {
  Findings all;
  Finding& f = all.findings.emplace_back();
  f.mechanism = id, f.kind = "sensor", f.channel = column;
  f.parameters.push_back({"amount", "", amount, amount - 0.001, amount + 0.001});
  return all;
}

TEST(WheelsSay, AnOffsetOfTheSteeringMayBeCoupledWheelsOfDifferentRadius) {
  vehicle::Vehicle car;
  car.parameters[vehicle::Parameter::rear_track_m] = 1.6;
  Findings all = found_at("sensor.bias", "delta", -0.004);
  say_that_wheels_are_coupled(turning_log(0.96), car, all);
  EXPECT_EQ(all.findings[0].mechanism, "vehicle.differential");
  EXPECT_NEAR(all.findings[0].parameters[0].value, 0.96, 0.01);
  EXPECT_EQ(all.findings[0].rivals.at(0).channel, "delta");
  EXPECT_FALSE(all.findings[0].not_used.empty());
  EXPECT_EQ(judge(all), Verdict::kTie);
  // Of another car than the file's, whose forces tell no offset.
  Findings other;
  other.doubtful_car = true;
  say_that_wheels_are_coupled(turning_log(0.96), car, other);
  ASSERT_EQ(other.findings.size(), 1U);
  EXPECT_EQ(other.findings[0].mechanism, "vehicle.differential");
  EXPECT_FALSE(other.findings[0].not_used.empty());
  car.terms[vehicle::Term::locked_differential] = 1;
  other.findings.clear();
  say_that_wheels_are_coupled(turning_log(0.96), car, other);
  EXPECT_TRUE(other.findings.empty()) << "its file says so";
  // Wheels that turn as the car does push it nowhere.
  all = found_at("sensor.bias", "delta", -0.004);
  say_that_wheels_are_coupled(turning_log(0.1), car, all);
  EXPECT_EQ(all.findings[0].mechanism, "sensor.bias");
}

TEST(WheelsSay, ASpeedThatIsTheWheelsHasTheirUsualErrors) {
  Signals log = turning_log(0.1);
  for (const auto& [id, amount, stays] : {std::tuple{"sensor.gain", 0.008, false},
                                          {"sensor.delay", 0.04, false},
                                          {"sensor.low_pass", 0.04, false},
                                          {"sensor.lever_arm", 0.04, true},
                                          {"sensor.gain", 0.06, true},
                                          {"sensor.delay", 0.4, true},
                                          {"sensor.bias", 0.3, true}}) {
    Findings all = found_at(id, "vx", amount);
    take_speeds_of_wheels_as_usual(log, all);
    EXPECT_EQ(all.findings.size(), stays ? 1U : 0U) << id << amount;
    EXPECT_EQ(all.remarks.size(), stays ? 0U : 1U);
  }
  for (double& v : log.x[kWheelRear]) v *= 1.01;
  Findings all = found_at("sensor.gain", "vx", 0.008);
  take_speeds_of_wheels_as_usual(log, all);
  EXPECT_EQ(all.findings.size(), 1U) << "a speed of its own";
}

}  // namespace judge_test
}  // namespace explain
