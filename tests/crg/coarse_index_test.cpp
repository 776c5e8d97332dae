// First guesses against places known beforehand, and what a cursor expects of the next query.
#include "coarse_index.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "locators.h"
#include "roads.h"

namespace crg {
namespace coarse_index_test {

struct Guesses {
  double exact = 0.0;  ///< share that is the very segment
  double near = 0.0;   ///< share not more than 12 segments and half a cache line of nodes off
};

Guesses guesses_on(const ReferenceLine& line, double half_width_m) {
  const Locator locator = test::locator_of(line, -half_width_m, half_width_m);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> row_of(0.0, static_cast<double>(line.size() - 1)),
      v_of(-half_width_m, half_width_m);
  constexpr int kPoints = 20000;
  Guesses all;
  for (int k = 0; k < kPoints; ++k) {
    const double row = row_of(random), v = v_of(random);
    const Point2 p = position(line, line.u_begin_m + row * line.u_step_m, v);
    const CoarseIndex::Guess guess = locator.guess(p.x_m, p.y_m);
    if (guess.segment == CoarseIndex::kNone) return {};
    const double off = std::abs(static_cast<double>(guess.segment) - std::floor(row));
    if (off == 0.0) all.exact += 1.0 / kPoints;
    if (off <= 12.0 && std::abs(static_cast<double>(guess.v_m) - v) < 0.4)
      all.near += 1.0 / kPoints;
  }
  return all;
}

// A guess that is the segment itself answers a query without a walk, and its v says which nodes
// to fetch. The straight line from a station alone would be the segment in 84 and 80 of 100 cases.
TEST(CoarseIndex, TheGuessIsMostlyTheSegmentItself) {
  const Guesses gentle = guesses_on(
      test::line_along(9000, 0.1, [](double u) { return 0.004 * std::sin(0.02 * u); }), 7.5);
  EXPECT_GT(gentle.exact, 0.95);
  EXPECT_GT(gentle.near, 0.9999);
  const Guesses hairpin = guesses_on(
      test::line_along(2500, 0.1, [](double u) { return u < 100.0 || u > 145.0 ? 0.0 : 0.066; }),
      6.0);
  EXPECT_GT(hairpin.exact, 0.9);
  EXPECT_GT(hairpin.near, 0.98);
}

TEST(CoarseIndex, FarFromTheRoadThereIsNone) {
  const ReferenceLine line = test::line_along(3000, 0.1, [](double) { return 0.0; });
  const Locator locator = test::locator_of(line, -5.0, 5.0);
  for (const Point2 p : {Point2{150.0, 400.0}, Point2{-1e4, 0.0}, Point2{1e300, 0.0},
                         Point2{NAN, 0.0}, Point2{0.0, NAN}, Point2{INFINITY, -INFINITY}})
    EXPECT_EQ(locator.guess(p.x_m, p.y_m).segment, CoarseIndex::kNone) << p.x_m << ", " << p.y_m;
}

TEST(Cursor, ExpectsTheNextQueryAsFarOnAsTheLast) {
  const ReferenceLine line =
      test::line_along(3000, 0.1, [](double u) { return 0.01 * std::sin(0.05 * u); });
  const Locator locator = test::locator_of(line, -5.0, 5.0);
  for (const double step : {0.6, -0.6, 3.7, -3.7}) {
    Cursor cursor;
    EXPECT_TRUE(is_new(cursor));
    EXPECT_GE(segment_ahead(cursor), locator.segments());
    int missed = 0;
    for (int k = 0; k < 500; ++k) {
      const double row = 1500.0 + 0.013 + step * (k - 250);
      const Point2 p = position(line, line.u_step_m * row, 2.0);
      Place place;
      if (locator.locate_ahead(p.x_m, p.y_m, cursor, place)) {
        EXPECT_EQ(place.segment, static_cast<std::size_t>(row));
        EXPECT_NEAR(place.v_m, 2.0, 1e-9);
      } else {
        ++missed;
        place = locator.locate(p.x_m, p.y_m, cursor);
      }
      // 19 bits of a cell, twice rounded
      EXPECT_NEAR(cursor.last - kCursorBias, row, 4e-6);
      EXPECT_EQ(leads_back(cursor), k > 0 && step < 0.0) << k;
    }
    EXPECT_LE(missed, 12) << step;  // the first two, and where a step ends at a mitre line
  }
}

}  // namespace coarse_index_test
}  // namespace crg
