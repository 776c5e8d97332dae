#include "explain/judge.h"

#include <gtest/gtest.h>

#include <cmath>

#include "explain/gyro_or_banking.h"

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

}  // namespace judge_test
}  // namespace explain
