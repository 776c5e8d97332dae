// Noise of pedals that loggers cut off at the stop.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "base/statistics.h"
#include "pedals.h"

namespace pedal_stops_test {

struct Log {
  std::vector<double> time_s, truth, value;
};

/// Presses of half a second every three; `noise` cut off below 0.
Log pressed(double noise, double step_s = 0.02) {
  Log out;
  base::Random dice = base::random_of(5, "brake");
  for (int k = 0; k < 1500; ++k) {
    const double t = step_s * k, since = std::fmod(t, 3.0) - 2.0;
    out.time_s.push_back(t);
    out.truth.push_back(since > 0.0 && since < 0.5 ? 2e6 * std::min(1.0, since / 0.1) : 0.0);
    out.value.push_back(std::max(0.0, out.truth.back() + noise * dice.normal()));
  }
  return out;
}

TEST(PedalStops, CutNoiseIsNoPressure) {
  for (const double step_s : {0.01, 0.02}) {
    const Log log = pressed(3e4, step_s);
    const identify::AtStop rests = identify::at_stop(log.time_s, log.value, 0.0);
    double held = 0.0, free = 0.0, wrong = 0.0, left_pa = 0.0;
    for (std::size_t k = 0; k < log.value.size(); ++k) {
      if (log.truth[k] > 0.0) {
        wrong += rests.row[k] ? 1.0 : 0.0;
        continue;
      }
      free += 1.0;
      held += rests.row[k] ? 1.0 : 0.0;
      left_pa += rests.row[k] ? 0.0 : log.value[k];
    }
    EXPECT_EQ(wrong, 0.0);
    EXPECT_GT(held, 0.95 * free);
    EXPECT_LT(left_pa / free, 2e3);  // 12,000 Pa as logged
    EXPECT_NEAR(rests.noise, 3e4, 3e3);
  }
}

TEST(PedalStops, ALogWithoutNoiseStaysAsItIs) {
  Log log = pressed(0.0);
  // Touches shorter than noise could tell from itself.
  for (std::size_t k = 20; k < 40; k += 10) log.value[k] = 1e5;
  const identify::AtStop rests = identify::at_stop(log.time_s, log.value, 0.0);
  EXPECT_EQ(std::count(rests.row.begin(), rests.row.end(), true), 0);
  EXPECT_EQ(rests.noise, 0.0);
}

TEST(PedalStops, AnOpenThrottleHasItsStopAbove) {
  Log log = pressed(3e4);
  std::vector<double> throttle;
  for (const double v : log.value) throttle.push_back(1.0 - v / 4e6);
  const identify::AtStop rests = identify::at_stop(log.time_s, throttle, 1.0);
  EXPECT_NEAR(rests.noise, 0.0075, 0.0008);
  EXPECT_GT(std::count(rests.row.begin(), rests.row.end(), true), 1100);
}

}  // namespace pedal_stops_test
