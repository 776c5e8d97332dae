#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "explain/findings.h"

namespace explain {
namespace seen_test {

using ::testing::HasSubstr, ::testing::Not;

Evidence tried(const char* mechanism, double amount, double score) {
  Evidence e;
  e.mechanism = mechanism;
  e.amount = amount;
  e.statistic = score;
  e.unit = "kg/s";
  return e;
}

TEST(Seen, IsWhatStandsOutOfTheNoiseAndIsNotNamed) {
  Findings f;
  f.threshold = 5;
  f.evidence = {tried("vehicle.fuel_burn", 0.0156, 16.7), tried("environment.wind", 1.0, 2.0),
                tried("vehicle.turbo_lag", -0.02, -4.0), tried("vehicle.mass", 1, 30),
                tried("vehicle.aero_drag", 1, 20)};
  f.evidence[0].least = 0.02;
  Finding found;
  found.mechanism = "vehicle.mass";
  found.rivals.push_back({"vehicle.aero_drag", "", "", 0, true});
  f.findings = {found};
  const std::vector<Seen> seen = seen_and_not_named(f);
  ASSERT_EQ(seen.size(), 2u) << "noise, findings and rivals are not among them";
  EXPECT_EQ(seen[0].mechanism, "vehicle.fuel_burn");
  // 0.0156 / 16.7 is a standard deviation of 0.000934; 90 % lie within 1.645 of them.
  EXPECT_NEAR(seen[0].low, 0.01406, 1e-5);
  EXPECT_NEAR(seen[0].high, 0.01714, 1e-5);
  EXPECT_THAT(seen[0].why, HasSubstr("less than 0.02 kg/s"));
  EXPECT_EQ(seen[1].mechanism, "vehicle.turbo_lag");
  EXPECT_LT(seen[1].low, seen[1].high);
  EXPECT_LT(seen[1].high, 0) << "the interval of what was seen does not hold nothing";
  EXPECT_THAT(seen[1].why, HasSubstr("score 4.0 where 5.0 is needed"));
}

TEST(Seen, ForcesOfAnotherCarSayNothing) {
  Findings f;
  f.doubtful_car = true;
  f.evidence = {tried("vehicle.fuel_burn", 0.17, 15), tried("sensor.bias", 0.002, 9)};
  const std::vector<Seen> seen = seen_and_not_named(f);
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_THAT(seen[0].why, HasSubstr("another car"));
  EXPECT_THAT(seen[1].why, Not(HasSubstr("another car"))) << "no forces take part";
}

TEST(Seen, AStretchOfRoadIsTheBestOfManyPlaces) {
  Findings f;
  f.threshold = 5;
  f.evidence = {tried("road.banking", 0.01, 4.5)};
  f.evidence[0].place = ", u 0 to 40 m";
  EXPECT_TRUE(seen_and_not_named(f).empty());
  f.evidence[0].statistic = 5.5;
  ASSERT_EQ(seen_and_not_named(f).size(), 1u);
  EXPECT_THAT(seen_and_not_named(f)[0].why, HasSubstr("laps left out"));
}

}  // namespace seen_test
}  // namespace explain
