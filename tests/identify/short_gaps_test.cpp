// Channels of different rates on one clock.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "identify/measure.h"

namespace short_gaps_test {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

TEST(ShortGaps, AreFilledAndLongOnesAreNot) {
  recording::Table log;
  std::vector<double> time, speed, gear;
  for (int k = 0; k < 200; ++k) {
    time.push_back(0.01 * k);
    // 10 Hz, silent from 0.7 to 1.2 s.
    const bool there = k % 10 == 0 && (k <= 70 || k >= 120);
    speed.push_back(there ? 20.0 + 0.1 * k : kNone);
    gear.push_back(there ? (k < 40 ? 3.0 : 4.0) : kNone);
  }
  log.add("time_s", time);
  log.add("vx_mps", speed);
  log.add("gear", gear);
  const auto filled = identify::without_short_gaps(recording::make_recording(log, "log"));
  const auto& v = *filled.table.find("vx_mps");
  const auto& g = *filled.table.find("gear");
  for (int k = 0; k <= 190; ++k) {
    const auto i = static_cast<std::size_t>(k);
    if (k > 70 && k < 120) {
      EXPECT_TRUE(std::isnan(v[i])) << k;
    } else {
      EXPECT_NEAR(v[i], 20.0 + 0.1 * k, 1e-12) << k;
      EXPECT_EQ(g[i], k < 40 ? 3.0 : 4.0) << k;
    }
  }
  EXPECT_TRUE(std::isnan(v[195]));  // nothing behind
}

TEST(ShortGaps, NoLineOverAGapOfTheRows) {
  recording::Table log;
  std::vector<double> time, speed;
  for (int k = 0; k < 40; ++k) {
    time.push_back(0.01 * k + (k < 20 ? 0.0 : 0.1));
    speed.push_back(k == 19 || k == 20 ? kNone : 20.0);
  }
  log.add("time_s", time);
  log.add("vx_mps", speed);
  const auto filled = identify::without_short_gaps(recording::make_recording(log, "log"));
  ASSERT_EQ(filled.stretches.size(), 2u);
  EXPECT_TRUE(std::isnan((*filled.table.find("vx_mps"))[19]));
  EXPECT_TRUE(std::isnan((*filled.table.find("vx_mps"))[20]));
}

}  // namespace short_gaps_test
