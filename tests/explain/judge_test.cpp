#include "explain/judge.h"

#include <gtest/gtest.h>

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

TEST(Judge, SomethingLeftAloneIsUnknown) {
  Findings all;
  all.unexplained.emplace_back();
  EXPECT_EQ(judge(all), Verdict::kUnknown);
}

TEST(Judge, HasTheWordsOfTheFormat) {
  EXPECT_STREQ(name_of(Verdict::kNone), "none");
  EXPECT_STREQ(name_of(Verdict::kExplained), "explained");
  EXPECT_STREQ(name_of(Verdict::kTie), "tie");
  EXPECT_STREQ(name_of(Verdict::kUnknown), "unknown");
}

}  // namespace judge_test
}  // namespace explain
