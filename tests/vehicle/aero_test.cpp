#include "vehicle/laws/aero.h"

#include <gtest/gtest.h>

#include <cmath>

#include "vehicle/laws/wake.h"

namespace aero_test {

using namespace vehicle;  // NOLINT: a test of this library
using P = Parameter;

// 50 m/s in air of 1.2 kg/m3: 1500 Pa. On 0.95 m2 1425 N of drag, on 1.1 and 1.6 m2 1650 and 2400 N
// of downforce.
TEST(Aero, ForcesAreAreasTimesDynamicPressure) {
  Parameters<double> p = default_parameters();
  p[P::aero_density_kgpm3] = 1.2;
  p[P::aero_drag_area_m2] = 0.95;
  p[P::front_lift_area_m2] = 1.1;
  p[P::rear_lift_area_m2] = 1.6;
  p[P::aero_side_area_m2] = 2.0;
  const auto f = laws::air_forces<double>(p, 50, 2500);
  EXPECT_NEAR(f.drag_nspm * 50, 1425, 1e-9);
  EXPECT_NEAR(f.front_n, 1650, 1e-9);
  EXPECT_NEAR(f.rear_n, 2400, 1e-9);
  // A car that slides to the left at 5 m/s is pushed to the right, by half the term half as much.
  EXPECT_NEAR(laws::side_force<double>(p, 1, 50, 5), -300, 1e-9);
  EXPECT_NEAR(laws::side_force<double>(p, 0.5, 50, 5), -150, 1e-9);
}

TEST(Aero, MapsActByTheirAmount) {
  const Map1 yaw{{0.0, 0.5}, {1.0, 1.4}};
  const Map2 ride{{0.0, 0.1}, {0.0, 0.1}, {1.0, 1.0, 0.8, 0.8}};
  EXPECT_NEAR(laws::map_factor<double>(1, yaw, 0.25), 1.2, 1e-12);
  EXPECT_NEAR(laws::map_factor<double>(0.5, yaw, 0.25), 1.1, 1e-12);
  EXPECT_NEAR(laws::map_factor<double>(1, ride, 0.05, 0.02), 0.9, 1e-12);
  EXPECT_EQ(laws::map_factor<double>(1, Map1{}, 0.25), 1);
  EXPECT_EQ(laws::map_factor<double>(1, Map2{}, 0.05, 0.02), 1);
}

// A map to 60 m behind the other car and to 4 m beside it, whose edges still have a deficit.
TEST(Aero, AWakeEndsBeyondItsMap) {
  const Map2 wake{{0.0, 60.0}, {-4.0, 0.0, 4.0}, {1.0, 1.0, 1.0, 0.99, 0.96, 0.99}};
  const auto deficit = [&](double x, double y) {
    return 1.0 - laws::wake_factor<double>(1, wake, x, y);
  };
  EXPECT_EQ(laws::wake_factor<double>(1, Map2{}, 30.0, 0.0), 1.0);
  EXPECT_NEAR(deficit(30.0, 0.0), 0.02, 1e-12);
  EXPECT_NEAR(deficit(60.0, 0.0), 0.04, 1e-12);
  EXPECT_NEAR(laws::wake_factor<double>(0.5, wake, 60.0, 0.0), 0.98, 1e-12);
  // 2.8284 lengths: 2^(-2/3 * 1.5) = 1/2.
  EXPECT_NEAR(deficit(60.0 * std::sqrt(8.0), 0.0), 0.02, 1e-12);
  EXPECT_NEAR(deficit(30.0, 6.0), 0.5 * deficit(30.0, 4.0), 1e-12);
  for (const double far : {600.0, 1000.0, 5000.0}) EXPECT_EQ(deficit(far, 0.0), 0.0);
  for (const double wide : {8.0, -8.0, 100.0, -5000.0}) EXPECT_EQ(deficit(30.0, wide), 0.0);
  // No step anywhere, and never more the farther away.
  double last = deficit(60.0, 0.0);
  for (double x = 60.0; x < 700.0; x += 0.5) {
    const double now = deficit(x, 0.0);
    EXPECT_LE(now, last);
    EXPECT_GT(now, last - 3e-4);
    last = now;
  }
}

}  // namespace aero_test
