#include "further_along.h"

#include <gtest/gtest.h>

#include <cmath>

namespace explain {
namespace further_along_test {

/// A car that speeds up by 2 m/s2 from 10 m/s: at t it is at 10 t + t2.
Signals speeding_up() {
  Signals s;
  s.n = 400;
  for (std::size_t i = 0; i < s.n; ++i)
    s.x[kVx].push_back(10 + 2 * Signals::kStep_s * static_cast<double>(i));
  return s;
}

double way_m(double place) {
  const double t = Signals::kStep_s * place;
  return 10 * t + t * t;
}

TEST(FurtherAlong, IsAsManyMetresAwayAsAsked) {
  const Signals s = speeding_up();
  for (const double shift_m : {-60.0, -7.5, 0.4, 60.0}) {
    const std::vector<double> place = further_along(s, shift_m);
    for (std::size_t i = 150; i < 250; ++i)
      ASSERT_NEAR(way_m(place[i]) - way_m(static_cast<double>(i)), shift_m, 0.002)
          << shift_m << " m from step " << i;
  }
}

TEST(FurtherAlong, EndsWhereTheRecordingDoes) {
  const Signals s = speeding_up();
  EXPECT_EQ(further_along(s, -60.0).front(), 0.0);
  EXPECT_NEAR(further_along(s, 60.0).back(), static_cast<double>(s.n - 1), 1e-9);
}

TEST(FurtherAlong, ReadsBetweenSteps) {
  const std::vector<double> x{1, 3, NAN, 4};
  EXPECT_EQ(at_step(x, 0.25), 1.5);
  EXPECT_EQ(at_step(x, 3.0), 4.0);
  EXPECT_TRUE(std::isnan(at_step(x, 1.5)));
}

}  // namespace further_along_test
}  // namespace explain
