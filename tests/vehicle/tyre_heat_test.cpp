#include "vehicle/laws/tyre_heat.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tyre_heat_test {

using namespace vehicle;  // NOLINT: a test of this library
using P = Parameter;

// Inside the window all grip is there; one width below it the flank x^2 / (1 + x^2) has half of
// its loss, far below nearly all; the amount scales it.
TEST(TyreHeat, GripsFullyInItsWindow) {
  const Parameters<double> p = default_parameters();
  const auto grip = [&](double tread_k, double amount = 1) {
    return laws::tread_factors<double>(p, {}, amount, tread_k).grip;
  };
  EXPECT_EQ(grip(p[P::tyre_window_begin_k]), 1.0);
  EXPECT_EQ(grip(0.5 * (p[P::tyre_window_begin_k] + p[P::tyre_window_end_k])), 1.0);
  EXPECT_EQ(grip(p[P::tyre_window_end_k]), 1.0);
  const double cold = p[P::tyre_window_begin_k] - p[P::tyre_cold_width_k];
  EXPECT_NEAR(grip(cold), 1 - 0.5 * p[P::tyre_cold_loss], 1e-12);
  EXPECT_NEAR(grip(cold, 0.5), 1 - 0.25 * p[P::tyre_cold_loss], 1e-12);
  EXPECT_NEAR(grip(p[P::tyre_window_begin_k] - 100 * p[P::tyre_cold_width_k]),
              1 - p[P::tyre_cold_loss], 1e-4);
  EXPECT_NEAR(grip(p[P::tyre_window_end_k] + p[P::tyre_hot_width_k]), 1 - 0.5 * p[P::tyre_hot_loss],
              1e-12);
}

// A measured map takes the place of the window: linear between its places, flat outside.
TEST(TyreHeat, GripsAsItsMapSays) {
  const Parameters<double> p = default_parameters();
  const Map1 map{{300, 350, 400}, {0.8, 1.0, 0.9}};
  const auto grip = [&](double k, double amount) {
    return laws::tread_factors<double>(p, map, amount, k).grip;
  };
  EXPECT_NEAR(grip(325, 1), 0.9, 1e-12);
  EXPECT_NEAR(grip(280, 1), 0.8, 1e-12);
  EXPECT_NEAR(grip(500, 1), 0.9, 1e-12);
  EXPECT_NEAR(grip(325, 0.5), 0.95, 1e-12);
}

// Exponential: the same ratio over the same distance, 1 at the window's begin.
TEST(TyreHeat, SoftensExponentially) {
  const Parameters<double> p = default_parameters();
  const double begin = p[P::tyre_window_begin_k];
  const auto soft = [&](double k) { return laws::tread_factors<double>(p, {}, 1.0, k).stiffness; };
  EXPECT_EQ(soft(begin), 1.0);
  EXPECT_NEAR(soft(begin + 20) / soft(begin), soft(begin) / soft(begin - 20), 1e-12);
  EXPECT_LT(soft(begin + 20), 1.0);
}

// Where heating and cooling balance by hand, the tread's temperature stays.
TEST(TyreHeat, BalancesSlidingAgainstAirAndRoad) {
  const Parameters<double> p = default_parameters();
  const double k = 370, speed = 30, air = p[P::environment_temperature_k],
               road = p[P::environment_track_temperature_k];
  const double out_w =
      (p[P::tyre_cooling_still_wpk] + p[P::tyre_cooling_speed_jpkm] * speed) * (k - air) +
      p[P::tyre_road_cooling_wpk] * (k - road);
  const double in_w = out_w / p[P::tyre_slip_share];
  EXPECT_NEAR(laws::tread_rate<double>(p, 5500, k, in_w, speed, true), 0, 1e-9);
  EXPECT_NEAR(
      laws::tread_rate<double>(p, 5500, k, in_w + 5500 / p[P::tyre_slip_share], speed, true), 1.0,
      1e-9);
  // In the air it loses nothing to the road; a patch that unwinds does not cool it.
  EXPECT_GT(laws::tread_rate<double>(p, 5500, k, in_w, speed, false), 0);
  EXPECT_EQ(laws::tread_rate<double>(p, 5500, k, -1e4, speed, true),
            laws::tread_rate<double>(p, 5500, k, 0, speed, true));
}

}  // namespace tyre_heat_test
