// Banking from the turning of a car alone, on drives that share no code with the library.
#include "explain/banking_by_turning.h"

#include <gtest/gtest.h>

#include <cmath>

#include "turning_drive.h"

namespace explain {
namespace banking_by_turning_test {

using explain_test::LeaningOval;
using explain_test::TurningDrive;

double degrees(double slope) { return std::atan(slope) * 180 / explain_test::kPi; }

BankingByTurning found(const TurningDrive& d) {
  const crg::Surface road(LeaningOval(d).flat_road());
  const recording::Table log = explain_test::logged(d);
  const Signals s = make_signals(log, identity_mapping(log), road, "log.csv");
  return banking_by_turning({turning_of(s)}, s.length_m, s.closed);
}

/// An oval whose stretches turn a little, like a tri-oval's.
TurningDrive oval() {
  TurningDrive d;
  d.stretch_radius_m = 700;
  d.lean_over_m = 100;
  d.into_turn_m = 90;
  d.speed_mps = 20;
  d.beside_m = 0;
  d.pivot_m = 0;
  return d;
}

TEST(BankingByTurning, FindsAnOvalThatLeans) {
  const BankingByTurning b = found(oval());
  EXPECT_EQ(b.by, TurningBy::kHeading);
  ASSERT_TRUE(b.counts) << b.saved << " of " << b.threshold;
  EXPECT_NEAR(degrees(b.lean), 20, 1.5);
  EXPECT_NEAR(b.delay_s, 0.3, 0.05);
  EXPECT_LT(std::abs(b.gain), 0.0035);
  // The two turns, and nothing where the road hardly leans.
  const LeaningOval road(oval());
  double both = 0, either = 0;
  for (const BankingPlace& p : b.places) {
    const bool is = road.lean_rad(p.u_m) < -14 * explain_test::kPi / 180;
    bool named = false;
    for (const auto& [begin, end] : b.where_m) named = named || (p.u_m >= begin && p.u_m <= end);
    both += is && named ? 1 : 0;
    either += is || named ? 1 : 0;
  }
  EXPECT_GT(both / either, 0.8);
}

TEST(BankingByTurning, ALineThatWasItselfDrivenDoesNotTellWhereOnTheRoad) {
  TurningDrive d = oval();
  d.wander_m = 1;
  const BankingByTurning b = found(d);
  ASSERT_TRUE(b.counts) << b.saved << " of " << b.threshold;
  EXPECT_NEAR(degrees(b.lean), 20, 1);
  EXPECT_NEAR(b.delay_s, 0.3, 0.05);
}

TEST(BankingByTurning, PositionsAreEnough) {
  TurningDrive d = oval();
  d.speed_mps = 45;
  d.heading = d.side_slip = false;
  const BankingByTurning b = found(d);
  EXPECT_EQ(b.by, TurningBy::kCourse);
  EXPECT_TRUE(b.counts) << b.saved << " of " << b.threshold;
  EXPECT_NEAR(degrees(b.lean), 20, 2);
}

TEST(BankingByTurning, AFlatRoadGetsALimitWhateverTheGainOfTheGyro) {
  TurningDrive d = oval();
  d.turn_deg = d.stretch_deg = 0;
  for (const double gain : {0.0, -0.04}) {
    d.gyro_gain = gain;
    const BankingByTurning b = found(d);
    // No gyro as it is usual is 4 % off: then the road may lean, or it is the gain.
    EXPECT_TRUE(gain == 0 ? !b.counts : b.may_be_gain) << b.saved << " of " << b.threshold;
    if (gain == 0) {
      EXPECT_LT(degrees(b.limit), 12);  // of 99 %
    }
  }
}

TEST(BankingByTurning, WithoutAGyroThereIsNothingToSay) {
  Signals s;
  s.n = 10;
  EXPECT_EQ(turning_of(s).by, TurningBy::kNone);
  EXPECT_TRUE(banking_by_turning({turning_of(s)}, 1000, true).places.empty());
}

}  // namespace banking_by_turning_test
}  // namespace explain
