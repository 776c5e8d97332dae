#include "whole_car_errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/random.h"

namespace whole_car_errors_test {

using explain::HeldOut;
using explain::SimulationCheck;
using explain::SquaredErrors;
using ::testing::HasSubstr;

/// Windows whose errors after are `factor` times those before, and vary by a third each.
std::vector<SquaredErrors> windows(std::size_t count, double factor, unsigned long long seed) {
  base::Random dice{seed};
  std::vector<SquaredErrors> out;
  for (std::size_t i = 0; i < count; ++i) {
    const double before = 2.0 * (1 + 0.33 * dice.normal()),
                 after = 2.0 * factor * (1 + 0.33 * dice.normal());
    out.push_back({before * before, after * after, 9.0, 16.0});
  }
  return out;
}

HeldOut errors_of(const std::vector<SquaredErrors>& all, unsigned long long seed = 1) {
  HeldOut out;
  out.channel = "vx_mps";
  out.unit = "m/s";
  explain::set_errors(all, seed, out);
  return out;
}

SimulationCheck drive_of(double factor) {
  SimulationCheck out;
  out.lap_before_s = out.lap_after_s = 80.0;
  out.held_out = {errors_of(windows(60, 1.0, 5)), errors_of(windows(60, factor, 6))};
  out.held_out[1].channel = "lateral_m";
  return out;
}

TEST(WholeCarErrors, AreRootsOfMeansWithHowSureTheDropIs) {
  const HeldOut row = errors_of({{4, 1, 9, 16}, {16, 4, 9, 16}, {1, 0.25, 9, 16}});
  EXPECT_NEAR(row.rmse_before, std::sqrt(7.0), 1e-12);
  EXPECT_NEAR(row.rmse_after, std::sqrt(1.75), 1e-12);
  EXPECT_DOUBLE_EQ(row.trivial_rmse, 3);
  EXPECT_DOUBLE_EQ(row.trend_rmse, 4);
  // Every window is half as large: whatever is drawn, it drops by half.
  for (const double drop : {row.drop_low, row.drop_high, row.sure_low, row.sure_high})
    EXPECT_NEAR(drop, 0.5, 1e-12);
}

// Without any difference one interval of ten excludes it, and one of 120 those for all rows at
// once, on either side half of them.
TEST(WholeCarErrors, IntervalsHoldWhatTheySay) {
  int alone = 0, together = 0;
  constexpr int kSets = 600;
  for (unsigned long long k = 0; k < kSets; ++k) {
    const HeldOut row = errors_of(windows(60, 1.0, 100 + k), k);
    alone += row.drop_low > 0 || row.drop_high < 0 ? 1 : 0;
    together += row.sure_low > 0 || row.sure_high < 0 ? 1 : 0;
  }
  EXPECT_NEAR(alone, 0.1 * kSets, 3 * std::sqrt(0.1 * kSets));
  EXPECT_LE(together, kSets / 120 + 3 * std::sqrt(kSets / 120.0));
}

TEST(WholeCar, IsBetterOrNotUsed) {
  EXPECT_EQ(why_not_used(drive_of(0.8), true), "");
  EXPECT_THAT(why_not_used(drive_of(1.0), true), HasSubstr("nothing is better for sure"));
  EXPECT_EQ(why_not_used(drive_of(1.0), false), "") << "a column's error moves no car";
  const std::string worse = why_not_used(drive_of(1.3), false);
  EXPECT_THAT(worse, HasSubstr("lateral_m of the whole car after 0.6 s"));
  EXPECT_THAT(worse, HasSubstr("worse by"));
  SimulationCheck better_and_worse = drive_of(1.3);
  better_and_worse.held_out[0] = errors_of(windows(60, 0.5, 7));
  EXPECT_EQ(why_not_used(better_and_worse, true), worse) << "what is better elsewhere is no excuse";
}

TEST(WholeCar, ALapThatIsNoLongerFinishedIsReasonEnough) {
  SimulationCheck drive = drive_of(0.8);
  drive.lap_after_s = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(why_not_used(drive, true), HasSubstr("does not finish a lap"));
  drive.lap_before_s = drive.lap_after_s;
  EXPECT_EQ(why_not_used(drive, true), "") << "nor did it as stated";
}

TEST(WholeCar, OneThatCannotBeDrivenAfterIsNotUsed) {
  SimulationCheck drive;
  drive.lap_before_s = 80;
  drive.before = explain::RefittedCar{};
  EXPECT_NE(why_not_used(drive, false), "");
}

TEST(WholeCar, WhatWasNotDrivenSpeaksAgainstNothing) {
  SimulationCheck none;
  none.lap_before_s = none.lap_after_s = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(why_not_used(none, true), "");
}

}  // namespace whole_car_errors_test
